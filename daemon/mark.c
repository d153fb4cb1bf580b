/* What is drawn over an equirectangular picture where the eye looks. */
#include <math.h>
#include <stdbool.h>

#include "mark.h"
#include "numbers.h"

enum { SIDES = 64 }; /* of the circle */
static const double FOVEA_DEG = 2.5,
                    CROSS_DEG = 0.6; /* radius of the circle, length of an arm of the cross */

struct drawing {
    double gaze[3], right[3], up[3]; /* a frame with the gaze ahead */
    double width, height;
    struct dmn_stroke *stroke;
    size_t count;
    double x, y; /* where the pen is */
};

static void cross(const double a[3], const double b[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void begin(struct drawing *drawing, const float gaze[3])
{
    const double up[3] = {0, 1, 0}, ahead[3] = {0, 0, -1};
    double length;

    for (int i = 0; i < 3; i++) drawing->gaze[i] = (double)gaze[i];
    cross(drawing->gaze, fabs(drawing->gaze[1]) < 0.999 ? up : ahead, drawing->right);
    length = sqrt(drawing->right[0] * drawing->right[0] + drawing->right[1] * drawing->right[1] +
                  drawing->right[2] * drawing->right[2]);
    for (int i = 0; i < 3; i++) drawing->right[i] /= length;
    cross(drawing->right, drawing->gaze, drawing->up);
}

static void add(struct drawing *drawing, double x, double y, bool down)
{
    drawing->stroke[drawing->count++] = (struct dmn_stroke){(float)x, (float)y, down};
}

/* Go to the point that is so far from the gaze, in that direction (rad, anticlockwise from the right). A line
 * that crosses the seam ends at one edge of the picture and goes on at the other. */
static void go(struct drawing *drawing, double distance_deg, double bearing, bool down)
{
    const double distance = distance_deg * M_PI / 180, width = drawing->width;
    double x, y, turn;
    float point[3];

    for (int i = 0; i < 3; i++)
        point[i] =
            (float)(cos(distance) * drawing->gaze[i] +
                    sin(distance) * (cos(bearing) * drawing->right[i] + sin(bearing) * drawing->up[i]));
    dmn_angles(point, &x, &y);
    x = (0.5 + x / 360) * width;
    y = (0.5 - y / 180) * drawing->height;
    turn = x - drawing->x > width / 2 ? -width : drawing->x - x > width / 2 ? width : 0;
    if (down && turn != 0) {
        const double edge = turn > 0 ? width : 0, step = x + turn - drawing->x,
                     middle = drawing->y + (step != 0 ? (edge - drawing->x) / step : 0) * (y - drawing->y);

        add(drawing, edge, middle, true);
        add(drawing, width - edge, middle, false);
    }
    add(drawing, x, y, down);
    drawing->x = x;
    drawing->y = y;
}

size_t dmn_mark(const float gaze[3], int width, int height, struct dmn_stroke out[DMN_MARK_MOST])
{
    struct drawing drawing = {.width = width, .height = height, .stroke = out};

    begin(&drawing, gaze);
    for (int i = 0; i <= SIDES; i++) go(&drawing, FOVEA_DEG, 2 * M_PI * i / SIDES, i > 0);
    for (int i = 0; i < 4; i++) {
        go(&drawing, 0, 0, false);
        go(&drawing, CROSS_DEG, M_PI / 2 * i, true);
    }
    return drawing.count;
}
_Static_assert(3 * (SIDES + 1 + 8) <= DMN_MARK_MOST, "every line may cross the seam");
