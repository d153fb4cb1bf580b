/* Which tiles a client is sent next.
 *
 * Levels form a tree: a tile at level n covers four at level n - 1. One walk over the tree, children first,
 * finds for every tile whether finer ones hide it from the client, or could do so at once, and keeps the best
 * of the tiles that are worth sending in a heap. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "fade.h"
#include "next.h"
#include "renderer.h"

/* Levels of at most so many tiles (512 x 256 pixels) are sent whole before finer ones. */
enum { COARSE_TILES = 32 };

/* Paths per pixel that a tile must have before it may hide a coarser one. The finest levels need more: with
 * fewer, noise hides their detail, and the coarser tile, with four times as many paths per pixel, shows more.
 */
enum { FINE_LEVELS = 3, FINE_PATHS = 4, COARSE_PATHS = 1 };

static uint64_t enough(int level)
{
    return (uint64_t)(level < FINE_LEVELS ? FINE_PATHS : COARSE_PATHS) * RND_TILE * RND_TILE;
}

/* By what factor its paths must have grown before a tile is sent again. Noise falls with their square root,
 * and a fall of less than a fifth is not visible. Where the eye would not see the change at all, the noise
 * must have halved. A tile that has settled is sent for the last time, so sooner. */
static const double GROWTH = 1.5, UNSEEN_GROWTH = 4, SETTLED_GROWTH = 1.1;

/* A tile that was sent before ranks as if it were so much further from the gaze, rad. */
static const float AGAIN = 0.035f;

/* Ranks: places without a picture, then coarse levels, then distances, which are below 4. */
static const float RANK_BLACK = -200, RANK_COARSE = -100;

/* --- the best few --- */

struct search {
    const struct dmn_pyramid *pyramid;
    const struct dmn_tile *sent;
    const float *gaze;
    float pixels_per_degree; /* of level 0 */
    int finest;
    size_t count, limit;
    struct dmn_place *heap; /* worst first */
};

/* A total order, so that the same tiles always give the same places. */
static int by_rank(const void *a, const void *b)
{
    const struct dmn_place *p = a, *q = b;

    if (p->rank != q->rank) return p->rank < q->rank ? -1 : 1;
    if (p->level != q->level) return q->level - p->level;
    return p->index < q->index ? -1 : 1;
}

static void sink(struct dmn_place *heap, size_t count, size_t at)
{
    for (;;) {
        size_t child = 2 * at + 1;

        if (child >= count) return;
        if (child + 1 < count && by_rank(&heap[child + 1], &heap[child]) > 0) child++;
        if (by_rank(&heap[at], &heap[child]) > 0) return;

        struct dmn_place held = heap[at];
        heap[at] = heap[child];
        heap[child] = held;
        at = child;
    }
}

static void offer(struct search *search, struct dmn_place place)
{
    if (search->count < search->limit) {
        search->heap[search->count++] = place;
        if (search->count == search->limit)
            for (size_t i = search->count / 2; i-- > 0;) sink(search->heap, search->count, i);
    } else if (by_rank(&place, &search->heap[0]) < 0) {
        search->heap[0] = place;
        sink(search->heap, search->count, 0);
    }
}

/* --- the walk --- */

/* Would the eye see the change of a tile's noise, if it were sent again? A level's pixels are as many times
 * wider as their noise is less, so what the eye sees does not depend on the level. */
static bool is_seen(const struct search *search, const struct dmn_tile *now, const struct dmn_tile *sent,
                    float away_rad)
{
    return isinf(now->error) ||
           dmn_change(now->error, sent->samples, now->samples) >=
               rnd_visible_error(away_rad * (float)(180 / M_PI), search->pixels_per_degree);
}

static bool has_grown(const struct dmn_tile *now, const struct dmn_tile *sent, bool visible)
{
    return (double)now->samples >= (visible ? GROWTH : UNSEEN_GROWTH) * (double)sent->samples ||
           (now->converged && !sent->converged && now->samples > sent->samples) ||
           (now->settled && !sent->settled && (double)now->samples >= SETTLED_GROWTH * (double)sent->samples);
}

/* Set the rank of a tile that finer ones neither hide nor could replace. False if it is not worth sending. */
static bool rank(const struct search *search, const struct dmn_tile *now, const struct dmn_tile *sent,
                 struct dmn_place *place)
{
    if (sent->samples > 0 && !has_grown(now, sent, true)) return false;
    place->rank = dmn_pyramid_eccentricity(search->pyramid, place->level, place->index, search->gaze);
    if (sent->samples == 0) return true;
    if (!has_grown(now, sent, is_seen(search, now, sent, place->rank))) return false;
    place->rank += AGAIN;
    return true;
}

/* Of a subtree: whether the client has a picture of all of it, and whether it could have a finer one at once.
 */
struct shown {
    bool all, soon;
};

/* above: a coarser tile shows this area, or will be sent. */
static struct shown walk(struct search *search, int level, int x, int y, bool above)
{
    const struct dmn_pyramid *pyramid = search->pyramid;
    size_t index = dmn_pyramid_index(pyramid, level, x, y);
    const struct dmn_tile *now = &pyramid->tile[index], *sent = &search->sent[index];
    bool coarsest = level == pyramid->levels - 1;
    bool ready = now->samples >= (coarsest ? 1 : enough(level)), has = sent->samples > 0;
    struct shown finer = {level > search->finest, level > search->finest};

    for (int child = 0; level > search->finest && child < 4; child++) {
        int column = x, row = y;
        struct shown s;

        if (!dmn_pyramid_child(pyramid, level, &column, &row, child)) continue;
        s = walk(search, level - 1, column, row, above || ready || has);
        finer.all &= s.all;
        finer.soon &= s.all || s.soon;
    }
    if (ready && !finer.all) {
        struct dmn_place place = {level, x, y, index, 0};
        int tiles = pyramid->level[level].columns * pyramid->level[level].rows;

        if (!has && !above)
            place.rank = RANK_BLACK - (float)level;
        else if (!has && tiles <= COARSE_TILES)
            place.rank = RANK_COARSE - (float)level;
        else if (finer.soon || !rank(search, now, sent, &place))
            place.level = -1;
        if (place.level >= 0) offer(search, place);
    }
    return (struct shown){has || finer.all, ready || finer.soon};
}

size_t dmn_next(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                int finest, size_t limit, struct dmn_place *out_places)
{
    struct search search = {pyramid, sent, gaze, dmn_pyramid_density(pyramid), finest, 0, limit, out_places};
    int top = pyramid->levels - 1;

    if (!limit) return 0;
    for (int y = 0; y < pyramid->level[top].rows; y++)
        for (int x = 0; x < pyramid->level[top].columns; x++) walk(&search, top, x, y, false);
    qsort(out_places, search.count, sizeof(*out_places), by_rank);
    return search.count;
}

/* --- where the eye looks --- */

bool dmn_seen_at(const struct dmn_pyramid *pyramid, const struct dmn_tile *sent, const float gaze[3],
                 int finest, struct dmn_place *out_place)
{
    size_t at = dmn_pyramid_at(pyramid, gaze);
    int column = (int)at % pyramid->level[0].columns, row = (int)at / pyramid->level[0].columns;

    for (int level = finest; level < pyramid->levels; level++) {
        int x = column >> level, y = row >> level;
        size_t index = dmn_pyramid_index(pyramid, level, x, y);

        if (!sent[index].samples) continue;
        *out_place = (struct dmn_place){level, x, y, index, 0};
        return pyramid->tile[index].samples > sent[index].samples;
    }
    return false;
}
