/* Sockets, timers and sessions on one thread. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <libwebsockets.h>

#include "edits.h"
#include "loop.h"

enum {
    MOST_CLIENTS = 64,
    MOST_STRANGERS = 16, /* of them, whose token has not been looked at: they leave room for others */
    MOST_FDS = MOST_CLIENTS + DMN_MAX_LISTEN + 16, /* and what libwebsockets needs itself */
    BURST = 8,                                     /* frames to one client before others have their turn */
};

/* The states of tiles are looked at every LOOK_NS at most, and for at most a tenth of the loop's time, which
 * matters for large films; but at least every LONGEST_PAUSE_NS. The cost of a look is processor time: on a
 * busy machine a look may last long without costing more. */
static const uint64_t LOOK_NS = 2000000, LONGEST_PAUSE_NS = 100000000;
/* When the gaze moves, what it makes of the tiles that have no new paths is looked at in so many parts. */
enum { LOOK_SHARE = 10, GAZE_PARTS = 16 };

/* How long the end waits for clients that do not read. */
static const lws_usec_t BYE_US = 1000000;

static const lws_usec_t TICK_US = 1000000 / DMN_CHECKS_A_SECOND;

/* A connected client. */
struct peer {
    struct peer *next;
    struct lws *wsi;
    struct dmn_session *session;
    bool needs_token;
};

struct dmn_loop {
    struct dmn_loop_options options;
    struct dmn_common *common;
    struct lws_context *context;
    struct lws_vhost *vhost;
    struct peer *peers;
    unsigned numbers; /* given to clients so far */
    lws_sorted_usec_list_t tick, look, bye;
    bool look_waits;
    uint64_t looked_ns, look_cost_ns, painted; /* batches painted at the last look */
    struct rnd_tile *tiles;
    uint32_t *changed;     /* room for the places of all of them */
    size_t outdated, part; /* tiles that were last looked at for another gaze, the first of them at part */
    bool stop, late;       /* the loop ends; clients have had time enough to take their Bye */
};

/* --- the state of the picture --- */

/* What this thread has had of the processor. */
static uint64_t processor_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

static void ask_to_write(struct dmn_loop *loop)
{
    for (struct peer *peer = loop->peers; peer; peer = peer->next)
        if (dmn_session_wants(peer->session)) lws_callback_on_writable(peer->wsi);
}

/* When a new generation begins, count tiles that still show the former one as empty. True if one has begun.
 */
static bool drop_old(struct dmn_loop *loop, uint32_t changes, size_t count)
{
    uint64_t newest = loop->common->generation;

    for (uint32_t i = 0; i < changes; i++)
        if (loop->tiles[loop->changed[i]].generation > newest)
            newest = loop->tiles[loop->changed[i]].generation;
    if (newest == loop->common->generation) return false;
    loop->common->generation = newest;
    for (size_t i = 0; i < count; i++)
        if (loop->tiles[i].generation != newest)
            loop->tiles[i] = (struct rnd_tile){
                .unvisited = RND_TILE * RND_TILE, .error = INFINITY, .sure_error = INFINITY};
    return true;
}

/* Take up what has become of a tile. */
static void take_tile(struct dmn_loop *loop, size_t i)
{
    struct dmn_common *common = loop->common;
    const struct rnd_tile *tile = &loop->tiles[i];
    int columns = common->pyramid.level[0].columns;
    struct dmn_tile state = {tile->samples, tile->converged,
                              rnd_tile_settled(common->render, tile, (int)i % columns, (int)i / columns,
                                               common->direction)},
                     before = common->pyramid.tile[i];

    common->visited += (state.samples > DMN_OUTLINE_PATHS) - (before.samples > DMN_OUTLINE_PATHS);
    common->converged += state.converged - before.converged;
    common->settled += state.settled - before.settled;
    dmn_pyramid_set(&common->pyramid, i, &state);
}

/* Take up what has become of the tiles since the last look: of those that have changed at once; of the
 * others, when the gaze has moved, part by part. whole: of all now. */
static void look(struct dmn_loop *loop, bool whole)
{
    struct dmn_common *common = loop->common;
    const struct dmn_level *level = &common->pyramid.level[0];
    size_t count = (size_t)level->columns * level->rows, part;
    uint64_t began_ns = processor_ns();
    uint32_t changes;
    struct dmn_gaze_state gaze;

    loop->looked_ns = dmn_now_ns();
    dmn_gaze_state(common->gaze, &gaze);
    changes = rnd_render_published(common->render, loop->tiles, loop->changed);
    whole |= drop_old(loop, changes, count);
    if (memcmp(common->direction, gaze.direction, sizeof(common->direction))) loop->outdated = count;
    memcpy(common->direction, gaze.direction, sizeof(common->direction));
    for (uint32_t i = 0; i < changes; i++) take_tile(loop, loop->changed[i]);
    part = count / GAZE_PARTS + 1;
    if (whole || part > loop->outdated) part = whole ? count : loop->outdated;
    for (size_t i = 0; i < part; i++) take_tile(loop, (loop->part + i) % count);
    loop->part = (loop->part + part) % count;
    loop->outdated = whole ? 0 : loop->outdated - part;
    dmn_pyramid_update(&common->pyramid);
    common->gaze_sequence = loop->tiles[dmn_pyramid_at(&common->pyramid, common->direction)].gaze_sequence;
    common->version++;
    loop->look_cost_ns = processor_ns() - began_ns;
}

static void on_look(lws_sorted_usec_list_t *sul)
{
    struct dmn_loop *loop = lws_container_of(sul, struct dmn_loop, look);

    loop->look_waits = false;
    look(loop, false);
    ask_to_write(loop);
}

/* Look now if the last time is long enough ago, else as soon as it is. */
static void look_soon(struct dmn_loop *loop)
{
    uint64_t pause_ns = LOOK_SHARE * loop->look_cost_ns, passed_ns = dmn_now_ns() - loop->looked_ns;

    if (pause_ns < LOOK_NS) pause_ns = LOOK_NS;
    if (pause_ns > LONGEST_PAUSE_NS) pause_ns = LONGEST_PAUSE_NS;
    if (loop->look_waits) return;
    if (passed_ns >= pause_ns) {
        look(loop, false);
        return;
    }
    loop->look_waits = true;
    lws_sul_schedule(loop->context, 0, &loop->look, on_look, (lws_usec_t)((pause_ns - passed_ns) / 1000 + 1));
}

static void drop(struct peer *peer, const char *why)
{
    size_t count;
    uint8_t *frame;

    dmn_print(stderr, "fovead: client %u (%s) dropped: %s\n", dmn_session_number(peer->session),
              dmn_session_peer(peer->session), why);
    if (lws_send_pipe_choked(peer->wsi) || !(frame = dmn_farewell(why, LWS_PRE, &count))) return;
    lws_write(peer->wsi, frame + LWS_PRE, count, LWS_WRITE_RAW);
    free(frame);
}

static void on_tick(lws_sorted_usec_list_t *sul)
{
    struct dmn_loop *loop = lws_container_of(sul, struct dmn_loop, tick);
    char error[PRO_ERROR_SIZE];

    look_soon(loop);
    for (struct peer *peer = loop->peers; peer; peer = peer->next) {
        dmn_session_stats(peer->session);
        if (dmn_session_check(peer->session, error)) continue;
        drop(peer, error);
        lws_set_timeout(peer->wsi, PENDING_TIMEOUT_KILLED_BY_PARENT, LWS_TO_KILL_ASYNC);
    }
    ask_to_write(loop);
    if (loop->options.tick) loop->options.tick(loop->options.context);
    lws_sul_schedule(loop->context, 0, &loop->tick, on_tick, TICK_US);
}

/* Another thread has done something. */
static void on_wake(struct dmn_loop *loop)
{
    struct dmn_work work;
    struct dmn_save save;

    while (dmn_saver_take(loop->common->saver, &save))
        for (struct peer *peer = loop->peers; peer; peer = peer->next)
            if (dmn_session_number(peer->session) == save.client) dmn_session_saved(peer->session, &save);
    if (loop->common->edits) dmn_edits_words(loop->common->edits, &loop->common->words);
    dmn_painter_work(loop->common->painter, &work);
    if (work.done) loop->stop = true;
    if (loop->peers && work.batches != loop->painted) look_soon(loop);
    loop->painted = work.batches;
    ask_to_write(loop);
}

/* --- libwebsockets' callbacks: one protocol a kind of descriptor --- */

static struct dmn_loop *loop_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* Is there no room for one more client of this listener? Then why, in at least 96 bytes. */
static bool is_full(const struct dmn_loop *loop, const struct dmn_listener *listener, char *out_why,
                    size_t size)
{
    unsigned strangers = 0;

    for (const struct peer *peer = loop->peers; peer; peer = peer->next)
        strangers += peer->needs_token && !dmn_session_greeted(peer->session);
    snprintf(out_why, size, "%d clients are connected, which is the most", MOST_CLIENTS);
    if (loop->common->clients >= MOST_CLIENTS) return true;
    snprintf(out_why, size, "%d clients are connected that have shown no token, which is the most",
             MOST_STRANGERS);
    return listener->token && strangers >= MOST_STRANGERS;
}

/* Tell the client why, if its socket takes that at once, and close it. */
static void turn_away(int fd, const char *name, const char *why)
{
    char unread[4096];
    uint8_t *frame;
    size_t count;

    dmn_print(stderr, "fovead: client (%s) turned away: %s\n", name, why);
    frame = dmn_farewell(why, 0, &count);
    if (frame) (void)!send(fd, frame, count, MSG_DONTWAIT | MSG_NOSIGNAL);
    free(frame);
    /* A socket that is closed with bytes unread may take back what it sent. */
    (void)!recv(fd, unread, sizeof(unread), MSG_DONTWAIT);
    close(fd);
}

static void welcome_in(struct dmn_loop *loop, struct dmn_listener *listener, int fd,
                       const struct dmn_peer *from)
{
    struct peer *peer = calloc(1, sizeof(*peer));
    struct dmn_session_options options = {loop->common,    loop->numbers + 1, from->name,
                                          listener->token, from->key,         listener->address.is_unix,
                                          LWS_PRE};
    lws_adopt_desc_t adopt = {
        .vh = loop->vhost, .type = LWS_ADOPT_SOCKET, .vh_prot_name = "client", .opaque = peer};

    if (!peer || !(peer->session = dmn_session_create(&options))) {
        free(peer);
        close(fd);
        return;
    }
    loop->numbers++;
    adopt.fd.sockfd = fd;
    /* On failure libwebsockets has closed fd, and may or may not have told on_client. */
    peer->wsi = lws_adopt_descriptor_vhost_via_info(&adopt);
    if (!peer->wsi) {
        dmn_print(stderr, "fovead: client %u (%s) cannot be served\n", loop->numbers, from->name);
        dmn_session_destroy(peer->session);
        free(peer);
        return;
    }
    peer->needs_token = listener->token;
    peer->next = loop->peers;
    loop->peers = peer;
}

static int on_listener(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_listener *listener;
    struct dmn_loop *loop;
    struct dmn_peer from;
    char why[96];
    int fd;

    (void)user, (void)in, (void)size;
    if (reason != LWS_CALLBACK_RAW_RX_FILE) return 0;
    loop = loop_of(wsi);
    listener = lws_get_opaque_user_data(wsi);
    while ((fd = dmn_listener_accept(listener, &from)) >= 0)
        if (loop->stop)
            turn_away(fd, from.name, "the daemon is ending");
        else if (is_full(loop, listener, why, sizeof(why)))
            turn_away(fd, from.name, why);
        else
            welcome_in(loop, listener, fd, &from);
    return 0;
}

static int write_some(struct peer *peer)
{
    for (int i = 0; i < BURST; i++) {
        size_t count;
        uint8_t *frame = dmn_session_frame(peer->session, &count);
        int written;

        if (!frame) return 0;
        written = lws_write(peer->wsi, frame + LWS_PRE, count, LWS_WRITE_RAW);
        free(frame);
        if (written < (int)count) return -1;
        /* What did not fit waits in libwebsockets: one frame at most. */
        if (lws_send_pipe_choked(peer->wsi)) break;
    }
    lws_callback_on_writable(peer->wsi);
    return 0;
}

static void part(struct dmn_loop *loop, struct peer *peer)
{
    struct peer **place = &loop->peers;

    while (*place && *place != peer) place = &(*place)->next;
    if (!*place) return; /* adoption failed half-way: welcome_in() cleans up */
    *place = peer->next;
    dmn_session_destroy(peer->session);
    free(peer);
}

static int on_client(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct peer *peer = wsi ? lws_get_opaque_user_data(wsi) : NULL;
    char error[PRO_ERROR_SIZE];

    (void)user;
    switch (reason) {
    case LWS_CALLBACK_RAW_ADOPT:
        /* Deadlines are the session's. */
        lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
        return 0;
    case LWS_CALLBACK_RAW_RX:
        if (!dmn_session_take(peer->session, in, size, error)) {
            drop(peer, error);
            return -1;
        }
        if (dmn_session_wants(peer->session)) lws_callback_on_writable(wsi);
        return 0;
    case LWS_CALLBACK_RAW_WRITEABLE:
        return write_some(peer);
    case LWS_CALLBACK_RAW_CLOSE:
        part(loop_of(wsi), peer);
        return 0;
    default:
        return 0;
    }
}

static int on_signal(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    (void)user, (void)in, (void)size;
    if (reason == LWS_CALLBACK_RAW_RX_FILE) loop_of(wsi)->stop = true;
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) on_wake(loop_of(wsi));
    return 0;
}

static const struct lws_protocols PROTOCOLS[] = {
    {.name = "signal", .callback = on_signal},
    {.name = "listener", .callback = on_listener},
    {.name = "client", .callback = on_client, .rx_buffer_size = 4096},
    {0},
};

/* --- life --- */

static bool adopt_file(struct dmn_loop *loop, int fd, const char *protocol, void *opaque)
{
    lws_adopt_desc_t adopt = {
        .vh = loop->vhost, .type = LWS_ADOPT_RAW_FILE_DESC, .vh_prot_name = protocol, .opaque = opaque};

    adopt.fd.filefd = fd;
    return lws_adopt_descriptor_vhost_via_info(&adopt);
}

static bool open_context(struct dmn_loop *loop)
{
    struct lws_context_creation_info info = {
        .port = CONTEXT_PORT_NO_LISTEN,
        .protocols = PROTOCOLS,
        .user = loop,
        .fd_limit_per_thread = MOST_FDS,
        .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
    };
    int fd;

    lws_set_log_level(LLL_ERR, NULL);
    if (!(loop->context = lws_create_context(&info)) ||
        !(loop->vhost = lws_create_vhost(loop->context, &info)))
        return false;
    /* Every descriptor that it adopts it also closes. */
    if ((fd = dup(loop->options.signal_fd)) < 0 || !adopt_file(loop, fd, "signal", NULL)) return false;
    for (int i = 0; i < loop->options.listeners; i++) {
        struct dmn_listener *listener = &loop->options.listener[i];

        if ((fd = dup(listener->fd)) < 0 || !adopt_file(loop, fd, "listener", listener)) return false;
    }
    return true;
}

struct dmn_loop *dmn_loop_create(const struct dmn_loop_options *options, char out_error[PRO_ERROR_SIZE])
{
    struct dmn_loop *loop = calloc(1, sizeof(*loop));
    const struct dmn_level *level = &options->common->pyramid.level[0];
    size_t count = (size_t)level->columns * level->rows;

    snprintf(out_error, PRO_ERROR_SIZE, "cannot set up the event loop: out of memory or of file descriptors");
    if (!loop) return NULL;
    loop->options = *options;
    loop->common = options->common;
    loop->tiles = calloc(count, sizeof(*loop->tiles));
    loop->changed = calloc(count, sizeof(*loop->changed));
    if (!loop->tiles || !loop->changed || !open_context(loop)) {
        dmn_loop_destroy(loop);
        return NULL;
    }
    return loop;
}

void dmn_loop_destroy(struct dmn_loop *loop)
{
    if (!loop) return;
    if (loop->context) {
        lws_sul_cancel(&loop->tick);
        lws_sul_cancel(&loop->look);
        lws_context_destroy(loop->context);
    }
    free(loop->tiles);
    free(loop->changed);
    free(loop);
}

void dmn_loop_look(struct dmn_loop *loop)
{
    look(loop, true);
}

void dmn_loop_wake(void *loop)
{
    lws_cancel_service(((struct dmn_loop *)loop)->context);
}

static void on_late(lws_sorted_usec_list_t *sul)
{
    lws_container_of(sul, struct dmn_loop, bye)->late = true;
}

static bool has_more_to_send(struct dmn_loop *loop)
{
    bool more = false;

    for (struct peer *peer = loop->peers; peer; peer = peer->next)
        more |= dmn_session_wants(peer->session) || lws_partial_buffered(peer->wsi);
    return more;
}

/* Tell every client that this is the end, and no crash. */
static void say_bye(struct dmn_loop *loop)
{
    for (struct peer *peer = loop->peers; peer; peer = peer->next) dmn_session_end(peer->session);
    ask_to_write(loop);
    lws_sul_schedule(loop->context, 0, &loop->bye, on_late, BYE_US);
    while (!loop->late && has_more_to_send(loop) && lws_service(loop->context, 0) >= 0) continue;
    lws_sul_cancel(&loop->bye);
}

void dmn_loop_run(struct dmn_loop *loop)
{
    trk_be_prompt(); /* messages come before the threads that trace paths */
    lws_sul_schedule(loop->context, 0, &loop->tick, on_tick, TICK_US);
    while (!loop->stop && lws_service(loop->context, 0) >= 0) continue;
    lws_sul_cancel(&loop->tick);
    say_bye(loop);
    lws_sul_cancel(&loop->look);
}
