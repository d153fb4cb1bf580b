/* Pull-push: a pixel that has paths shows their mean, and a pixel without any shows the mean of the smallest
 * square around it that has some (Gortler, Grzeszczuk, Szeliski and Cohen 1996).
 *
 * The squares of pixels form a tree: each has four parts, down to single pixels. The mean of a square is the
 * mean of its parts that have paths; each part counts alike, whatever the number of its paths. From the top
 * of the tree down, every square hands its mean on to its parts. A part without a path takes the mean of the
 * square. A part whose paths have found no light yet may only have been unlucky: it takes a share of the
 * square's light too, and the other parts give as much, each in proportion to its own light. So a single
 * bright hit is spread over the square that it stands for, and the sum of the light stays the same.
 */
#include "reconstruct/reconstruction.h"

#include <math.h>
#include <string.h>

enum { TOP = 6 }; /* 2^6 = RND_TILE */
_Static_assert(RND_TILE == 1 << TOP, "the tree below has so many levels");

/* A part that found no light is taken for black once it has SURE_PATHS paths and would be expected to have
 * SURE_HITS hits if it were like the square around it: with three expected, one part in twenty finds none
 * (the rule of three: Hanley and Lippman-Hand 1983). */
#define SURE_PATHS 64.0f
#define SURE_HITS  3.0f

struct node {
    float mean[3];
    float paths, hits; /* 0 paths: nothing is known */
    bool mixed;        /* a part has no path, or has found no light */
    bool lent;         /* it shows another mean than its own */
};

static bool is_black(const struct node *node)
{
    return node->mean[0] + node->mean[1] + node->mean[2] <= 0.0f;
}

static void sum_up(const struct node *const part[4], struct node *out)
{
    float parts = 0.0f;
    *out = (struct node){0};
    for (int i = 0; i < 4; i++) {
        out->mixed |= part[i]->paths <= 0.0f || is_black(part[i]);
        if (part[i]->paths <= 0.0f) continue;
        for (int c = 0; c < 3; c++) out->mean[c] += part[i]->mean[c];
        out->paths += part[i]->paths;
        out->hits += part[i]->hits;
        parts += 1.0f;
    }
    for (int c = 0; c < 3 && parts > 1.0f; c++) out->mean[c] /= parts;
}

/* How uncertain it is that the parts without light are black: 0 certain, 1 unknown. */
static float doubt(const struct node *whole, const struct node *const part[4])
{
    float most = 0.0f;
    for (int i = 0; i < 4; i++) {
        if (part[i]->paths <= 0.0f || !is_black(part[i])) continue;
        const float few = 1.0f - part[i]->paths / SURE_PATHS;
        const float hits = whole->hits / whole->paths * part[i]->paths; /* that would be expected */
        most = fmaxf(most, fmaxf(few, (SURE_HITS - hits) / (SURE_HITS - 1.0f)));
    }
    return fminf(most, 1.0f);
}

/* Set the means that the parts show, so that their mean is what the whole shows. */
static void hand_down(const struct node *shown, struct node *const part[4])
{
    struct node whole;
    const struct node *const known[4] = {part[0], part[1], part[2], part[3]};
    sum_up(known, &whole);
    const float even = shown->mixed ? doubt(&whole, known) : 0.0f;
    for (int i = 0; i < 4; i++) {
        part[i]->lent = shown->lent || even > 0.0f || part[i]->paths <= 0.0f;
        if (!part[i]->lent) continue;
        for (int c = 0; c < 3; c++) {
            float own = shown->mean[c];
            if (part[i]->paths > 0.0f && whole.mean[c] > 0.0f)
                own *= even + (1.0f - even) * (part[i]->mean[c] / whole.mean[c]);
            part[i]->mean[c] = own;
        }
    }
}

/* The four parts of a node of a level. */
static void parts_of(struct node *finer, int side, int i, struct node *out[4])
{
    struct node *first = finer + (i / side) * 2 * (2 * side) + (i % side) * 2;
    out[0] = first;
    out[1] = first + 1;
    out[2] = first + 2 * side;
    out[3] = first + 2 * side + 1;
}

static bool run(void *memory, const struct rnd_window *window, float *out_rgb)
{
    (void)memory;
    struct node tree[RND_TILE * RND_TILE * 4 / 3 + 1], *level[TOP + 1] = {tree}, *part[4];
    bool mixed = false;
    for (int i = 0; i < RND_TILE * RND_TILE; i++) {
        const struct rnd_sum *sum = &window->pixel[i];
        const float share = sum->area > 0.0f ? 1.0f / sum->area : 0.0f;
        tree[i] = (struct node){.paths = sum->paths, .hits = sum->hits};
        for (int c = 0; c < 3; c++) out_rgb[3 * i + c] = tree[i].mean[c] = sum->light[c] * share;
        mixed |= sum->paths <= 0.0f || is_black(&tree[i]);
    }
    if (!mixed) return true; /* as it is nearly always, after a while */
    for (int l = 1; l <= TOP; l++) {
        const int finer = RND_TILE >> (l - 1), side = RND_TILE >> l;
        level[l] = level[l - 1] + finer * finer;
        for (int i = 0; i < side * side; i++) {
            parts_of(level[l - 1], side, i, part);
            sum_up((const struct node *const[4]){part[0], part[1], part[2], part[3]}, &level[l][i]);
        }
    }
    if (level[TOP]->paths <= 0.0f) return false;
    for (int l = TOP; l >= 1; l--) {
        const int side = RND_TILE >> l;
        for (int i = 0; i < side * side; i++) {
            if (!level[l][i].mixed && !level[l][i].lent) continue;
            parts_of(level[l - 1], side, i, part);
            hand_down(&level[l][i], part);
        }
    }
    for (int i = 0; i < RND_TILE * RND_TILE; i++) memcpy(&out_rgb[3 * i], tree[i].mean, sizeof tree[i].mean);
    return true;
}

/* Every square of 2^n x 2^n pixels that has a path shows the mean of its parts that have one, unless a larger
 * square lends it light or borrows some. */
const struct rnd_reconstruction rnd_reconstruction_pull_push = {
    .name = "pull-push",
    .summary = "pixels without a path take the mean of those around them",
    .source = "Gortler, Grzeszczuk, Szeliski and Cohen 1996: the Lumigraph",
    .run = run,
};
