/* The order of the clients that show a view. */
#include "steering.h"

static bool goes_before(const struct dmn_shown *a, const struct dmn_shown *b)
{
    return a->headset != b->headset ? a->headset : a->asked > b->asked;
}

static void take_out(struct dmn_steering *steering, const struct dmn_shown *client)
{
    struct dmn_shown **place = &steering->first;

    while (*place && *place != client) place = &(*place)->next;
    if (*place) *place = client->next;
}

static void put_in(struct dmn_steering *steering, struct dmn_shown *client)
{
    struct dmn_shown **place = &steering->first;

    while (*place && !goes_before(client, *place)) place = &(*place)->next;
    client->next = *place;
    *place = client;
}

void dmn_steering_show(struct dmn_steering *steering, struct dmn_shown *client,
                       const struct trk_view *view_or_null, bool headset, bool asks)
{
    const struct dmn_shown *before = steering->first;
    const bool was_headset = client->shown && client->headset, was_shown = client->shown;

    if (headset) asks = !was_headset;
    client->shown = view_or_null;
    client->headset = view_or_null && headset;
    if (!view_or_null)
        client->asked = 0;
    else if (asks)
        client->asked = ++steering->asks;
    if (view_or_null) client->view = *view_or_null;
    /* A client whose rank has not changed keeps its place. Taking it out and putting it in again would move
     * it behind clients of equal rank. */
    if (!was_shown || !client->shown || asks || client->headset != was_headset) {
        take_out(steering, client);
        if (client->shown) put_in(steering, client);
    }
    steering->changes += steering->first != before;
}
