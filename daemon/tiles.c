/* The tiles that a client is sent. */
#include <string.h>

#include "fade.h"
#include "paint.h"
#include "tiles.h"

uint64_t dmn_clock_ns(const struct dmn_handles *handles)
{
    struct dmn_work work;

    if (!handles->options->virtual_clock) return dmn_now_ns();
    dmn_painter_work(handles->painter, &work);
    return work.now_ns;
}

/* Is more known of this tile than the client was sent? */
static bool is_new(const struct dmn_client *client, const struct dmn_place *place)
{
    return client->picture->pyramid.tile[place->index].samples > client->sent[place->index].samples;
}

/* Choose the tiles to send next. */
static void plan(struct dmn_client *client)
{
    const struct dmn_picture *picture = client->picture;

    if (client->generation != picture->generation)
        memset(client->sent, 0, picture->pyramid.count * sizeof(*client->sent));
    client->generation = picture->generation;
    client->next = client->planned = 0;
    if (picture->gaze_sequence > client->gaze_sequence) {
        /* The tile that the eye sees comes first, so that every gaze is answered. */
        client->gaze_sequence = picture->gaze_sequence;
        client->planned =
            dmn_seen_at(&picture->pyramid, client->sent, picture->direction, client->finest, client->plan);
    }
    client->planned += dmn_next(&picture->pyramid, client->sent, picture->direction, client->finest,
                                DMN_PLAN - client->planned, client->plan + client->planned);
    client->plan_version = picture->version;
}

bool dmn_tile_is_due(struct dmn_client *client)
{
    const struct dmn_picture *picture = client->picture;

    if (!client->sent || client->serial - client->acknowledged >= client->window) return false;
    if (client->plan_version != picture->version) plan(client);
    /* The tile that the eye sees may have been planned twice. */
    while (client->next < client->planned && !is_new(client, &client->plan[client->next])) client->next++;
    return client->next < client->planned;
}

uint8_t *dmn_tile_pack(struct dmn_client *client, size_t *out_count)
{
    const struct dmn_place *place = &client->plan[client->next++];
    const struct dmn_tile *known = &client->picture->pyramid.tile[place->index];
    const struct dmn_encoded *encoded =
        dmn_encode(&client->clients->encoder, client->picture, place, client->encoding);
    const struct rnd_tile *read;
    Fovea__Tile tile = FOVEA__TILE__INIT;
    struct dmn_tile now;

    if (!encoded) return NULL;
    read = &encoded->read;
    /* The plan, and what is known of the tile, are of the former generation. */
    if (read->generation != client->generation) return NULL;
    tile.data.data = encoded->bytes;
    tile.data.len = encoded->count;
    now = (struct dmn_tile){read->samples, known->converged, known->settled, read->error};
    tile.fade_ms = dmn_fade_of(&client->picture->pyramid, client->sent, client->picture->direction,
                               place->level, place->x, place->y, &now);
    client->sent[place->index] = now;
    tile.serial = ++client->serial;
    tile.generation = client->generation;
    tile.level = (uint32_t)place->level;
    tile.x = (uint32_t)place->x;
    tile.y = (uint32_t)place->y;
    tile.encoding = client->encoding;
    tile.samples = read->samples;
    tile.error = read->error;
    tile.converged = known->converged;
    tile.settled = known->settled;
    if (read->gaze_sequence > client->gaze_sequence) client->gaze_sequence = read->gaze_sequence;
    tile.gaze_sequence = read->gaze_sequence;
    tile.gaze_ns = read->gaze_ns;
    tile.aimed_ns = read->aimed_ns;
    tile.encoded_ns = dmn_clock_ns(client->handles);
    return dmn_client_pack(client, FOVEA__MESSAGE__BODY_TILE, &tile, out_count);
}
