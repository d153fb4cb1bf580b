/* Points of a screen as directions through a view, and back. */
#include "view.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* Half the width and height of the desk's screen, in distances of the eye. */
static const double desk[2] = {0.26 / 0.65, 0.14625 / 0.65};

/* A point may be off the view by rounding: a tenth of a pixel in a thousand. */
static const double slack = 1e-4;

/* The place of a point in the view: x to the right, y upwards, -1 to 1 from edge to edge. */
static void place_of(const struct trk_view *view, const float point[2], double out_place[2])
{
    for (int i = 0; i < 2; i++)
        out_place[i] = ((double)point[i] - (double)view->screen[i]) / (double)view->screen[2 + i] * 2 - 1;
    out_place[1] = -out_place[1];
}

static void direction_at(const struct trk_view *view, const double place[2], float out_world[3])
{
    double v[3] = {place[0] * tan((double)view->fov[0] / 2), place[1] * tan((double)view->fov[1] / 2), -1};
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + 1);
    vec3 direction = {(float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length)};
    versor orientation; /* a copy: cglm's is aligned */
    memcpy(orientation, view->orientation, sizeof orientation);
    glm_quat_rotatev(orientation, direction, direction);
    glm_vec3_normalize(direction);
    memcpy(out_world, direction, sizeof direction);
}

bool trk_view_shows(const struct trk_view *view, const float point[2])
{
    double place[2];
    place_of(view, point, place);
    return fabs(place[0]) <= 1 + slack && fabs(place[1]) <= 1 + slack; /* not if they are NaN */
}

void trk_view_nearest(const struct trk_view *view, const float point[2], float out_world[3])
{
    double place[2];
    place_of(view, point, place);
    for (int i = 0; i < 2; i++) place[i] = fmax(-1, fmin(place[i], 1));
    direction_at(view, place, out_world);
}

bool trk_view_direction(const struct trk_view *view, const float point[2], float out_world[3])
{
    if (!trk_view_shows(view, point)) return false;
    trk_view_nearest(view, point, out_world);
    return true;
}

bool trk_view_point(const struct trk_view *view, const float world[3], float out_point[2])
{
    vec3 direction = {world[0], world[1], world[2]};
    versor back;
    memcpy(back, view->orientation, sizeof back);
    glm_quat_conjugate(back, back);
    glm_quat_rotatev(back, direction, direction);
    if (!(direction[2] < -1e-6f)) return false;
    for (int i = 0; i < 2; i++) {
        double place = (double)direction[i] / -(double)direction[2] / tan((double)view->fov[i] / 2);
        if (!(fabs(place) <= 1 + slack)) return false;
        out_point[i] =
            (float)((double)view->screen[i] + (double)view->screen[2 + i] * ((i ? -place : place) + 1) / 2);
    }
    return true;
}

void trk_desk_direction(const float point[2], float out_direction[3])
{
    double x = (2 * (double)point[0] - 1) * desk[0], y = (1 - 2 * (double)point[1]) * desk[1];
    double length = sqrt(x * x + y * y + 1);
    out_direction[0] = (float)(x / length);
    out_direction[1] = (float)(y / length);
    out_direction[2] = (float)(-1 / length);
}

void trk_desk_point(const float direction[3], float out_point[2])
{
    double ahead = fmax(-(double)direction[2], 1e-6);
    out_point[0] = (float)(0.5 + (double)direction[0] / ahead / desk[0] / 2);
    out_point[1] = (float)(0.5 - (double)direction[1] / ahead / desk[1] / 2);
}
