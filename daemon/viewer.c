/* Shows the picture in tev or HDRView. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>

#include "dial.h"
#include "gaze.h"
#include "grown.h"
#include "mark.h"
#include "viewer.h"

/* While connected, fovead checks every BEAT_NS for a new gaze and for the tiles that have gained most paths.
 * At most TILES of them are sent per beat, which is 26 MB/s with five channels: a viewer queues all that it
 * gets, even if it cannot keep up. If fewer than FEW tiles have WORTH times the paths that they were sent
 * with, the FEW that have grown most are sent, however little they have grown. */
enum { TILES = 16, FEW = 4, HURRIED = 64, BURST = 2, SEND_BUFFER = 1 << 20 };
static const double WORTH = 1.5;

/* Sending may use at most a tenth of fovead's processor time, which is little on a busy machine. Time left
 * over from earlier beats is kept, up to MOST_SAVED_NS. At the end there is no such limit. */
enum { SHARE = 10 };
static const int64_t MOST_SAVED_NS = 5000000;

static const uint64_t BEAT_NS = 50000000, RETRY_NS = 1000000000;
/* A viewer that takes nothing for so long is dropped, and one that was dropped is left alone for a while. */
static const uint64_t PATIENCE_NS = 10000000000, PAUSE_NS = 30000000000;
/* At the end: how long to wait for a viewer that takes nothing, and for all of the picture. */
static const uint64_t LAST_PATIENCE_NS = 3000000000, LAST_NS = 20000000000;

enum told { TOLD_NOTHING, TOLD_ABSENT, TOLD_THERE };

struct dmn_viewer {
    struct lws_context *context;
    struct lws_vhost *vhost;
    struct pro_address address;
    char where[PRO_ERROR_SIZE]; /* the address, for people: "tcp:HOST:PORT" */
    const struct dmn_handles *handles;
    const struct dmn_picture *picture;
    struct pro_tev_image image;
    char name[320];
    const char *channel[RND_MOST_CHANNELS + 1];

    lws_sorted_usec_list_t beat;
    struct lws *dial, *socket; /* an attempt to connect; the connection; NULL: none */
    uint64_t since_ns;         /* of the connection */
    enum told told;
    const char *why; /* it is dropped; NULL: it is not */

    bool opened;         /* the picture, in the viewer */
    bool all;            /* even tiles that have hardly changed are sent, and as fast as they are taken */
    uint64_t generation; /* of the tiles sent */
    uint64_t *sent;      /* paths that the tiles of level 0 had when they were sent; 0: they were not */
    uint32_t plan[HURRIED];
    size_t planned, next;
    float gaze[3]; /* where the mark is, or should be; 0 at first */
    bool mark_due;
    uint8_t *packet; /* that is being sent; NULL: none */
    size_t count, done;
    uint64_t taken_ns; /* when the socket last had room, or there was nothing to send */
    uint64_t used_ns;  /* processor time of fovead up to the last beat */
    int64_t saved_ns;  /* that may still be spent on tiles; below 0: too much was */
};

static uint64_t processor_ns(clockid_t whose)
{
    struct timespec now;

    clock_gettime(whose, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* --- what is due --- */

/* The mark goes where the gaze is now, if there is one. */
static void follow_gaze(struct dmn_viewer *viewer)
{
    struct dmn_gaze_status gaze;

    if (!viewer->handles->options->gaze) return;
    dmn_gaze_status(viewer->handles->gaze, &gaze);
    if (memcmp(viewer->gaze, gaze.direction, sizeof(viewer->gaze))) viewer->mark_due = true;
    memcpy(viewer->gaze, gaze.direction, sizeof(viewer->gaze));
}

/* Choose the tiles to send next. */
static void plan(struct dmn_viewer *viewer)
{
    const struct dmn_picture *picture = viewer->picture;
    const struct dmn_tile *tile = picture->pyramid.tile;
    const uint64_t *sent = viewer->sent;

    if (viewer->generation != picture->generation)
        memset(viewer->sent, 0, picture->tiles * sizeof(*viewer->sent));
    viewer->generation = picture->generation;
    viewer->next = 0;
    if (viewer->all) {
        viewer->planned = dmn_grown(tile, sent, picture->tiles, 1, HURRIED, viewer->plan);
        return;
    }
    viewer->planned = 0;
    if (viewer->saved_ns <= 0) return;
    viewer->planned = dmn_grown(tile, sent, picture->tiles, WORTH, TILES, viewer->plan);
    if (viewer->planned < FEW) viewer->planned = dmn_grown(tile, sent, picture->tiles, 1, FEW, viewer->plan);
}

static bool tile_is_due(struct dmn_viewer *viewer)
{
    if (viewer->all && viewer->next == viewer->planned) plan(viewer);
    return viewer->next < viewer->planned;
}

static bool has_more(struct dmn_viewer *viewer)
{
    return viewer->packet || !viewer->opened || viewer->mark_due || tile_is_due(viewer);
}

/* --- packets --- */

static uint8_t *draw_mark(struct dmn_viewer *viewer, size_t *out_count)
{
    struct dmn_stroke stroke[DMN_MARK_MOST];
    struct pro_tev_command command[DMN_MARK_MOST + 3];
    const size_t strokes = dmn_mark(viewer->gaze, viewer->image.width, viewer->image.height, stroke);
    size_t count = 0;

    viewer->mark_due = false;
    command[count++] = (struct pro_tev_command){PRO_TEV_BEGIN, {0}};
    command[count++] = (struct pro_tev_command){PRO_TEV_COLOUR, {1, 0.75f, 0, 1}};
    for (size_t i = 0; i < strokes; i++)
        command[count++] = (struct pro_tev_command){stroke[i].down ? PRO_TEV_LINE_TO : PRO_TEV_MOVE_TO,
                                                    {stroke[i].x, stroke[i].y}};
    command[count++] = (struct pro_tev_command){PRO_TEV_STROKE, {0}};
    return pro_tev_draw(&viewer->image, command, (int)count, out_count);
}

/* Colour is what clients are shown; the other channels are those of the film. */
static uint8_t *read_tile(struct dmn_viewer *viewer, uint32_t index, size_t *out_count)
{
    struct rnd_render *render = viewer->handles->render;
    const int columns = viewer->picture->pyramid.level[0].columns, x = (int)index % columns,
              y = (int)index / columns, channels = viewer->image.channels;
    float values[RND_TILE * RND_TILE * RND_MOST_CHANNELS], rgb[RND_TILE * RND_TILE * 3];
    /* Films are whole tiles, so no part of one is outside. */
    const struct pro_tev_part part = {x * RND_TILE, y * RND_TILE, RND_TILE, RND_TILE, values};
    struct rnd_tile state, colour;

    if (!rnd_render_read_channels(render, x, y, values, &state) ||
        !rnd_render_read(render, 0, x, y, rgb, &colour))
        return NULL;
    /* The plan is of the former generation. */
    if (state.generation != viewer->generation || colour.generation != viewer->generation) return NULL;
    for (int i = 0; i < RND_TILE * RND_TILE; i++)
        memcpy(values + i * channels, rgb + 3 * i, 3 * sizeof(*rgb));
    viewer->sent[index] = state.samples;
    return pro_tev_update(&viewer->image, &part, out_count);
}

/* NULL if there is none, or memory is short. */
static uint8_t *next_packet(struct dmn_viewer *viewer, size_t *out_count)
{
    if (!viewer->opened) {
        uint8_t *packet = pro_tev_create(&viewer->image, out_count);

        viewer->opened = packet;
        return packet;
    }
    if (viewer->mark_due) return draw_mark(viewer, out_count);
    if (tile_is_due(viewer)) return read_tile(viewer, viewer->plan[viewer->next++], out_count);
    return NULL;
}

/* --- the connection --- */

/* Say in one line what has become of the viewer, if that has not been said. */
static void tell(struct dmn_viewer *viewer, enum told what, const char *line)
{
    if (viewer->told == what) return;
    viewer->told = what;
    dmn_print(stderr, "fovead: viewer at %s: %s%s\n", viewer->where + strlen("tcp:"), line,
              what == TOLD_ABSENT ? "; fovead goes on trying" : "");
}

static void schedule(struct dmn_viewer *viewer, uint64_t pause_ns);

static void drop(struct dmn_viewer *viewer, const char *why)
{
    viewer->why = why;
    lws_set_timeout(viewer->socket, PENDING_TIMEOUT_KILLED_BY_PARENT, LWS_TO_KILL_ASYNC);
}

static void ask_to_write(struct dmn_viewer *viewer)
{
    if (has_more(viewer))
        lws_callback_on_writable(viewer->socket);
    else
        viewer->taken_ns = dmn_now_ns();
}

/* The socket has room: send up to BURST packets, as far as it takes them. False if the connection is broken.
 */
static bool send_some(struct dmn_viewer *viewer)
{
    const uint64_t began_ns = processor_ns(CLOCK_THREAD_CPUTIME_ID);

    viewer->taken_ns = dmn_now_ns();
    for (int packets = 0; packets < BURST; packets++) {
        ssize_t taken;

        if (!viewer->packet) viewer->packet = next_packet(viewer, &viewer->count);
        if (!viewer->packet) break;
        taken = send(lws_get_socket_fd(viewer->socket), viewer->packet + viewer->done,
                     viewer->count - viewer->done, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (taken < 0 && errno != EAGAIN && errno != EINTR) return false;
        if (taken > 0) viewer->done += (size_t)taken;
        if (viewer->done < viewer->count) break;
        free(viewer->packet);
        viewer->packet = NULL;
        viewer->done = 0;
    }
    ask_to_write(viewer);
    viewer->saved_ns -= (int64_t)(processor_ns(CLOCK_THREAD_CPUTIME_ID) - began_ns);
    return true;
}

/* A connection begins or has ended. */
static void reset(struct dmn_viewer *viewer)
{
    free(viewer->packet);
    viewer->packet = NULL;
    viewer->done = viewer->planned = viewer->next = 0;
    viewer->opened = viewer->mark_due = false;
    viewer->why = NULL;
    memset(viewer->gaze, 0, sizeof(viewer->gaze));
    memset(viewer->sent, 0, viewer->picture->tiles * sizeof(*viewer->sent));
}

static void on_close(struct dmn_viewer *viewer)
{
    const char *why = viewer->why;

    viewer->socket = NULL;
    tell(viewer, TOLD_ABSENT, why ? why : "it has gone");
    reset(viewer);
    schedule(viewer, why ? PAUSE_NS : RETRY_NS);
}

static int on_socket(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_viewer *viewer = wsi ? lws_get_opaque_user_data(wsi) : NULL;

    (void)user, (void)in, (void)size;
    if (!viewer) return 0;
    switch (reason) {
    case LWS_CALLBACK_RAW_ADOPT:
        lws_set_timeout(wsi, NO_PENDING_TIMEOUT, 0);
        return 0;
    case LWS_CALLBACK_RAW_RX:
        viewer->why = "this is not a viewer: it has sent something, which tev and HDRView never do";
        return -1;
    case LWS_CALLBACK_RAW_WRITEABLE:
        return viewer->why || send_some(viewer) ? 0 : -1;
    case LWS_CALLBACK_RAW_CLOSE:
        if (viewer->socket == wsi) on_close(viewer);
        return 0;
    default:
        return 0;
    }
}

static struct lws *adopt(struct dmn_viewer *viewer, int fd, lws_adoption_type type, const char *protocol)
{
    lws_adopt_desc_t adopt = {.vh = viewer->vhost, .type = type, .vh_prot_name = protocol, .opaque = viewer};

    /* Both kinds of descriptor are the same int. On failure libwebsockets has closed it. */
    adopt.fd.sockfd = fd;
    return lws_adopt_descriptor_vhost_via_info(&adopt);
}

static void on_dialled(struct dmn_viewer *viewer, int pipe)
{
    struct dmn_dialled dialled;

    dmn_dial_take(pipe, &dialled);
    if (dialled.fd < 0) {
        tell(viewer, TOLD_ABSENT, dialled.why);
        return;
    }
    setsockopt(dialled.fd, SOL_SOCKET, SO_SNDBUF, &(int){SEND_BUFFER}, sizeof(int));
    viewer->socket = adopt(viewer, dialled.fd, LWS_ADOPT_SOCKET, "viewer");
    viewer->since_ns = viewer->taken_ns = dmn_now_ns();
    if (!viewer->socket) return;
    schedule(viewer, 0);
}

static int on_dial(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    struct dmn_viewer *viewer = wsi ? lws_get_opaque_user_data(wsi) : NULL;

    (void)user, (void)in, (void)size;
    if (!viewer) return 0;
    if (reason == LWS_CALLBACK_RAW_CLOSE_FILE) viewer->dial = NULL;
    if (reason != LWS_CALLBACK_RAW_RX_FILE) return 0;
    on_dialled(viewer, lws_get_socket_fd(wsi));
    return -1;
}

static const struct lws_protocols protocols[] = {
    {.name = "viewer", .callback = on_socket, .rx_buffer_size = 64},
    {.name = "dial", .callback = on_dial},
    {.name = NULL},
};

/* --- as time passes --- */

static void save_time(struct dmn_viewer *viewer)
{
    const uint64_t used_ns = processor_ns(CLOCK_PROCESS_CPUTIME_ID);

    viewer->saved_ns += (int64_t)((used_ns - viewer->used_ns) / SHARE);
    if (viewer->saved_ns > MOST_SAVED_NS) viewer->saved_ns = MOST_SAVED_NS;
    viewer->used_ns = used_ns;
}

static void check(struct dmn_viewer *viewer)
{
    const uint64_t now_ns = dmn_now_ns();

    save_time(viewer);
    if (viewer->why) return;
    if (now_ns - viewer->since_ns >= RETRY_NS)
        tell(viewer, TOLD_THERE, "connected; the picture is being sent");
    if (now_ns - viewer->taken_ns >= PATIENCE_NS) {
        drop(viewer, "it takes nothing");
        return;
    }
    follow_gaze(viewer);
    plan(viewer);
    ask_to_write(viewer);
}

static void on_beat(lws_sorted_usec_list_t *sul)
{
    struct dmn_viewer *viewer = lws_container_of(sul, struct dmn_viewer, beat);
    int fd;

    if (viewer->socket) {
        check(viewer);
        schedule(viewer, BEAT_NS);
        return;
    }
    if (!viewer->dial && (fd = dmn_dial(&viewer->address)) >= 0)
        viewer->dial = adopt(viewer, fd, LWS_ADOPT_RAW_FILE_DESC, "dial");
    schedule(viewer, RETRY_NS);
}

static void schedule(struct dmn_viewer *viewer, uint64_t pause_ns)
{
    lws_sul_schedule(viewer->context, 0, &viewer->beat, on_beat, (lws_usec_t)(pause_ns / 1000 + 1));
}

/* --- life --- */

static bool open_vhost(struct dmn_viewer *viewer)
{
    struct lws_context_creation_info info = {
        .port = CONTEXT_PORT_NO_LISTEN,
        .vhost_name = "viewer",
        .protocols = protocols,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
    };

    viewer->vhost = lws_create_vhost(viewer->context, &info);
    return viewer->vhost;
}

static void name_image(struct dmn_viewer *viewer)
{
    const struct dmn_options *options = viewer->handles->options;
    const char *slash = strrchr(options->scene.path, '/');
    struct pro_tev_image *image = &viewer->image;

    snprintf(viewer->name, sizeof(viewer->name), "fovead %s", slash ? slash + 1 : options->scene.path);
    rnd_make_printable(viewer->name);
    *image = (struct pro_tev_image){.name = viewer->name,
                                    .width = options->render.width,
                                    .height = options->render.height,
                                    .channel = viewer->channel};
    while ((viewer->channel[image->channels] = rnd_render_channel(viewer->handles->render, image->channels)))
        image->channels++;
}

struct dmn_viewer *dmn_viewer_create(struct lws_context *context, const struct pro_address *address,
                                     const struct dmn_handles *handles, const struct dmn_picture *picture)
{
    struct dmn_viewer *viewer = calloc(1, sizeof(*viewer));

    if (!viewer) return NULL;
    viewer->context = context;
    viewer->address = *address;
    viewer->handles = handles;
    viewer->picture = picture;
    viewer->sent = calloc(picture->tiles, sizeof(*viewer->sent));
    if (!viewer->sent || !open_vhost(viewer)) {
        dmn_viewer_destroy(viewer);
        return NULL;
    }
    pro_address_print(address, viewer->where, sizeof(viewer->where));
    name_image(viewer);
    schedule(viewer, 0);
    return viewer;
}

void dmn_viewer_destroy(struct dmn_viewer *viewer)
{
    if (!viewer) return;
    lws_sul_cancel(&viewer->beat);
    /* The context closes them, and calls back. */
    if (viewer->dial) lws_set_opaque_user_data(viewer->dial, NULL);
    if (viewer->socket) lws_set_opaque_user_data(viewer->socket, NULL);
    free(viewer->packet);
    free(viewer->sent);
    free(viewer);
}

bool dmn_viewer_is_there(const struct dmn_viewer *viewer)
{
    return viewer && viewer->socket;
}

void dmn_viewer_complete(struct dmn_viewer *viewer)
{
    const uint64_t began_ns = dmn_now_ns();
    uint64_t now_ns = began_ns;

    if (!viewer) return;
    viewer->all = true;
    viewer->taken_ns = began_ns;
    if (viewer->socket) ask_to_write(viewer);
    while ((viewer->dial || (viewer->socket && !viewer->why && has_more(viewer))) &&
           now_ns - began_ns < LAST_NS && now_ns - viewer->taken_ns < LAST_PATIENCE_NS &&
           lws_service(viewer->context, 0) >= 0)
        now_ns = dmn_now_ns();
}
