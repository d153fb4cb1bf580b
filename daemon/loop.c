/* Sockets, timers and sessions on one thread. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <libwebsockets.h>

#include "edits.h"
#include "loop.h"
#include "paint.h"
#include "transport/connection.h"
#include "transport/room.h"
#include "transport/table.h"
#include "transport/tls.h"
#include "viewer.h"

enum {
    ACCEPTED = 16, /* connections at most before other sockets have their turn */
    VIEWER = 2,    /* a connection to a viewer, and an attempt at one */
    /* The last are for libwebsockets itself. */
    MOST_FDS = DMN_MOST_CLIENTS + DMN_MOST_VISITS + ACCEPTED + DMN_MAX_LISTEN + VIEWER + 16,
};

/* What is known of the picture is updated every UPDATE_NS at most, and for at most a tenth of the loop's
 * time, which matters for large films; but at least every LONGEST_PAUSE_NS. The cost of an update is
 * processor time: on a busy machine an update may last long without costing more. */
static const uint64_t UPDATE_NS = 1000000, LONGEST_PAUSE_NS = 100000000;
enum { UPDATE_SHARE = 10 };

/* How long to wait at the end for clients that do not read. */
static const lws_usec_t BYE_US = 1000000;

static const lws_usec_t TICK_US = 1000000 / DMN_CHECKS_A_SECOND;

struct dmn_loop {
    struct dmn_loop_options options;
    struct dmn_clients clients;
    struct lws_context *context;
    struct lws_vhost *files; /* signals and listeners */
    struct lws_vhost *clients_of[DMN_TRANSPORTS];
    struct dmn_connection *connections;
    struct dmn_viewer *viewer; /* NULL: none is wanted */
    unsigned numbers;          /* numbers given to clients so far */
    lws_sorted_usec_list_t tick, update, bye;
    bool update_waits;
    uint64_t updated_ns, update_cost_ns;
    uint64_t painted; /* batches at the last wake */
    bool stop, late;  /* the loop ends; clients have had time enough to take their Bye */
};

/* --- the picture --- */

/* What this thread has had of the processor. */
static uint64_t processor_ns(void)
{
    struct timespec now;

    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

static void ask_to_write(struct dmn_loop *loop)
{
    for (struct dmn_connection *c = loop->connections; c; c = c->next) dmn_connection_wake(c);
}

static void update(struct dmn_loop *loop, bool whole)
{
    uint64_t began_ns = processor_ns();
    struct dmn_gaze_status gaze;

    loop->updated_ns = dmn_now_ns();
    dmn_gaze_status(loop->options.handles->gaze, &gaze);
    dmn_picture_update(loop->options.picture, gaze.direction, whole);
    loop->update_cost_ns = processor_ns() - began_ns;
}

static void on_update(lws_sorted_usec_list_t *sul)
{
    struct dmn_loop *loop = lws_container_of(sul, struct dmn_loop, update);

    loop->update_waits = false;
    update(loop, false);
    ask_to_write(loop);
}

/* Update now if the last time is long enough ago, else as soon as it is. */
static void update_soon(struct dmn_loop *loop)
{
    uint64_t pause_ns = UPDATE_SHARE * loop->update_cost_ns, passed_ns = dmn_now_ns() - loop->updated_ns;

    if (pause_ns < UPDATE_NS) pause_ns = UPDATE_NS;
    if (pause_ns > LONGEST_PAUSE_NS) pause_ns = LONGEST_PAUSE_NS;
    if (loop->update_waits) return;
    if (passed_ns >= pause_ns) {
        update(loop, false);
        return;
    }
    loop->update_waits = true;
    lws_sul_schedule(loop->context, 0, &loop->update, on_update,
                     (lws_usec_t)((pause_ns - passed_ns) / 1000 + 1));
}

/* --- what happens --- */

static void on_tick(lws_sorted_usec_list_t *sul)
{
    struct dmn_loop *loop = lws_container_of(sul, struct dmn_loop, tick);

    update_soon(loop);
    for (struct dmn_connection *c = loop->connections; c; c = c->next) dmn_connection_check(c);
    ask_to_write(loop);
    if (loop->options.tick) loop->options.tick(loop->options.context);
    lws_sul_schedule(loop->context, 0, &loop->tick, on_tick, TICK_US);
}

/* Another thread has done something. */
static void on_wake(struct dmn_loop *loop)
{
    const struct dmn_handles *handles = loop->options.handles;
    struct dmn_work work;
    struct dmn_job job;

    while (dmn_jobs_take(handles->jobs, &job)) {
        if (!job.client) loop->options.job_done(loop->options.context, &job);
        for (struct dmn_connection *c = loop->connections; c; c = c->next)
            if (c->client && c->options.number == job.client) dmn_session_done(c->client, &job);
    }
    if (handles->edits) dmn_edits_words(handles->edits, &loop->options.picture->scene);
    dmn_painter_work(handles->painter, &work);
    if (work.done) loop->stop = true;
    if ((loop->connections || dmn_viewer_is_there(loop->viewer)) && work.batches != loop->painted)
        update_soon(loop);
    loop->painted = work.batches;
    ask_to_write(loop);
}

static struct dmn_loop *loop_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* A client has connected: serve it, or turn it away. */
static void meet(struct dmn_loop *loop, const struct dmn_listener *listener, int fd,
                 const struct dmn_peer *peer)
{
    const int t = dmn_transport_of(listener);
    const struct dmn_transport *transport = dmn_transports[t];
    const struct dmn_arrival arrival = {loop->clients_of[t], transport, listener, fd, *peer};
    struct dmn_client_options options = {.clients = &loop->clients, .token = listener->token};
    char why[96] = "the daemon is ending";
    const bool is_good = transport->origin_is_good(peer, why, sizeof(why));

    if (transport->is_http) dmn_room_for_visit(loop->connections);
    if (is_good && !loop->stop &&
        (transport->is_http || dmn_room_for_client(loop->connections, listener, why, sizeof(why)))) {
        options.number = ++loop->numbers;
        dmn_connection_open(&loop->connections, &arrival, &options);
        return;
    }
    dmn_print(stderr, "fovead: client (%s) turned away: %s\n", peer->name, why);
    if (is_good && transport->refuse) transport->refuse(fd, why); /* others are told nothing */
    close(fd);
}

/* --- libwebsockets' callbacks for what is no client --- */

static int on_listener(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_listener *listener;
    struct dmn_peer peer;
    int fd;

    (void)user, (void)in, (void)size;
    if (reason != LWS_CALLBACK_RAW_RX_FILE) return 0;
    listener = lws_get_opaque_user_data(wsi);
    for (int i = 0; i < ACCEPTED && (fd = dmn_listener_accept(listener, &peer)) >= 0; i++)
        meet(loop_of(wsi), listener, fd, &peer);
    return 0;
}

static int on_signal(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    (void)user, (void)in, (void)size;
    if (reason == LWS_CALLBACK_RAW_RX_FILE) loop_of(wsi)->stop = true;
    if (reason == LWS_CALLBACK_EVENT_WAIT_CANCELLED) on_wake(loop_of(wsi));
    return 0;
}

static const struct lws_protocols files[] = {
    {.name = "signal", .callback = on_signal},
    {.name = "listener", .callback = on_listener},
    {.name = NULL},
};

/* --- life --- */

static bool adopt_file(struct dmn_loop *loop, int fd, const char *protocol, void *opaque)
{
    lws_adopt_desc_t adopt = {
        .vh = loop->files, .type = LWS_ADOPT_RAW_FILE_DESC, .vh_prot_name = protocol, .opaque = opaque};

    adopt.fd.filefd = fd;
    return lws_adopt_descriptor_vhost_via_info(&adopt);
}

/* libwebsockets moves an HTTP request to whichever virtual host of the same port the Host header names. So
 * the virtual host for HTTP has a "port" of its own; neither value is a port that libwebsockets listens on.
 */
static bool open_vhosts(struct dmn_loop *loop, struct lws_context_creation_info *info)
{
    for (int i = 0; i < DMN_TRANSPORTS; i++) {
        struct lws_context_creation_info own = *info;

        own.vhost_name = dmn_transports[i]->name;
        own.protocols = dmn_transports[i]->protocols;
        if (dmn_transports[i]->is_http) {
            own.port = CONTEXT_PORT_NO_LISTEN_SERVER;
            if (loop->options.tls) dmn_tls_ask(loop->options.tls, &own);
        }
        if (!(loop->clients_of[i] = lws_create_vhost(loop->context, &own))) return false;
    }
    info->vhost_name = "files";
    info->protocols = files;
    loop->files = lws_create_vhost(loop->context, info);
    return loop->files;
}

static void on_log(int level, const char *line)
{
    (void)level;
    dmn_print(stderr, "fovead: libwebsockets: %.*s\n", (int)strcspn(line, "\n"), line);
}

static bool open_viewer(struct dmn_loop *loop)
{
    const struct dmn_handles *handles = loop->options.handles;

    if (!handles->options->has_viewer) return true;
    loop->viewer =
        dmn_viewer_create(loop->context, &handles->options->viewer, handles, loop->options.picture);
    return loop->viewer;
}

static bool open_context(struct dmn_loop *loop)
{
    struct lws_context_creation_info info = {
        .port = CONTEXT_PORT_NO_LISTEN,
        .user = loop,
        .fd_limit_per_thread = MOST_FDS,
        .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
    };
    int fd;

    if (loop->options.tls) dmn_tls_prepare(loop->options.tls, &info);
    lws_set_log_level(LLL_ERR, on_log);
    if (!(loop->context = lws_create_context(&info)) || !open_vhosts(loop, &info)) return false;
    /* libwebsockets closes every descriptor that it adopts. */
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

    snprintf(out_error, PRO_ERROR_SIZE, "cannot set up the event loop: out of memory or of file descriptors");
    if (!loop) return NULL;
    loop->options = *options;
    loop->clients.handles = options->handles;
    loop->clients.picture = options->picture;
    if (open_context(loop) && open_viewer(loop)) return loop;
    dmn_loop_destroy(loop);
    return NULL;
}

void dmn_loop_destroy(struct dmn_loop *loop)
{
    if (!loop) return;
    if (loop->context) {
        lws_sul_cancel(&loop->tick);
        lws_sul_cancel(&loop->update);
        dmn_viewer_destroy(loop->viewer);
        lws_context_destroy(loop->context);
    }
    dmn_encoder_finish(&loop->clients.encoder);
    free(loop);
}

void dmn_loop_complete(struct dmn_loop *loop)
{
    update(loop, true);
    dmn_viewer_complete(loop->viewer);
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

    for (struct dmn_connection *c = loop->connections; c; c = c->next) more |= dmn_connection_has_more(c);
    return more;
}

/* Tell every client that the daemon ends in order. */
static void say_bye(struct dmn_loop *loop)
{
    for (struct dmn_connection *c = loop->connections; c; c = c->next)
        if (c->client) dmn_session_end(c->client);
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
    lws_sul_cancel(&loop->update);
}
