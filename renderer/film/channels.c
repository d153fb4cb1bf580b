/* The table of channels, and reading them. */
#include "film/channels.h"
#include "film/film.h"

#include <string.h>

/* Those of every film, in the order in which rnd_film_read_channels() writes them. Those of planes follow. */
static const struct {
    const char *name;
    bool floats; /* counts would lose their last digits as halves */
} table[] = {{"R", false}, {"G", false}, {"B", false}, {"samples", true}, {"error", false}};
enum { OWN = sizeof table / sizeof *table };
_Static_assert((int)OWN + (int)RND_PLANE_MOST_CHANNELS <= (int)RND_MOST_CHANNELS, "a film has more channels");

int rnd_film_channels(const struct rnd_film *film)
{
    return OWN + film->planes.channels;
}

const char *rnd_film_channel(const struct rnd_film *film, int index, bool *out_floats)
{
    if (index >= OWN) return rnd_planes_channel(&film->planes, index - OWN, out_floats);
    *out_floats = table[index].floats;
    return table[index].name;
}

/* Positions are kept in the scene's own coordinates. Paths that hit nothing have none, and count as 0. */
static void put_in_world(const struct rnd_planes *planes, const struct rnd_camera *camera, float *values)
{
    const int first = planes->first[RND_PLANE_POSITION];
    if (first < 0) return;
    const double coverage = (double)values[planes->first[RND_PLANE_COVERAGE]];
    for (int k = 0; k < 3; k++)
        values[first + k] = (float)((double)values[first + k] + coverage * camera->origin[k]);
}

void rnd_film_read_channels(const struct rnd_film *film, struct rnd_film_tile *tile, float *out)
{
    const int channels = rnd_film_channels(film);
    memset(out, 0, (size_t)channels * RND_TILE_PIXELS * sizeof *out);
    if (tile->state.samples == 0) return; /* and its memory need not be touched */
    if (!tile->spread) rnd_film_spread(tile);
    for (uint32_t i = 0; i < RND_TILE_PIXELS; i++, out += channels) {
        const struct rnd_film_pixel *pixel = &tile->pixels->pixel[i];
        const uint32_t paths = rnd_film_mean(pixel, out);
        out[3] = (float)paths;
        out[4] = rnd_film_error(pixel);
        if (film->planes.channels == 0 || paths == 0) continue;
        rnd_planes_sum(&film->planes, rnd_film_record(film, tile, i), out + OWN);
        put_in_world(&film->planes, &tile->camera, out + OWN);
    }
}
