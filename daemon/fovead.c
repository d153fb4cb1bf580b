/* fovead: the daemon. It loads the scene, opens its sockets, starts its threads, serves clients, and ends all
 * of that in order. */
#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "autosave.h"
#include "edits.h"
#include "file.h"
#include "jobs.h"
#include "loop.h"
#include "report.h"
#include "save.h"
#include "streams.h"
#include "trackers.h"
#include "transport/tls.h"

/* How long a batch takes. A new gaze waits for it, but shorter batches trace fewer paths per second. Without
 * gaze or clients longer ones serve. */
static const double STEERED_SECONDS = 0.0022, UNSTEERED_SECONDS = 0.05;

/* Signals within this time are one request: GNU timeout signals a program and then its group; a closed
 * terminal signals all that ran in it, and so does the shell. */
static const int64_t SAME_REQUEST_NS = 1000000000;

/* What a signal handler can reach. */
static int signal_fd = -1;
static atomic_bool serving;                /* any thread may receive the signal */
static atomic_uint_least64_t signalled_ns; /* when the first signal came; 0: none has */

/* The first signal ends the daemon in order. A signal a second or more later, or before the daemon serves,
 * ends it at once. */
static void on_signal(int number)
{
    const uint64_t one = 1, now_ns = dmn_now_ns();
    const int error = errno;
    uint64_t first_ns = 0;

    if (!atomic_load(&serving)) _exit(128 + number);
    if (atomic_compare_exchange_strong(&signalled_ns, &first_ns, now_ns)) {
        if (write(signal_fd, &one, sizeof(one)) < 0) _exit(128 + number);
    } else if ((int64_t)(now_ns - first_ns) >= SAME_REQUEST_NS) { /* two threads may be here at a time */
        _exit(128 + number);
    }
    errno = error;
}

struct daemon {
    struct dmn_options options;
    struct rnd_scene *scene;
    struct dmn_handles handles;
    struct dmn_picture picture;
    struct dmn_listener listener[DMN_MAX_LISTEN];
    int listeners;
    struct dmn_tls *tls; /* NULL: no listener speaks it */
    struct dmn_loop *loop;
    struct dmn_bar bar;
    struct dmn_told told;
    struct dmn_autosave autosave;
    FILE *out; /* for people: stdout, unless a JSON object goes there */
};

static bool fail(const char *error)
{
    dmn_print(stderr, "fovead: %s\n", error);
    return false;
}

static bool handle_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = SA_RESTART}, before;

    signal_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (signal_fd < 0 || sigaction(SIGINT, &action, NULL) || sigaction(SIGTERM, &action, NULL) ||
        sigaction(SIGHUP, NULL, &before))
        return false;
    /* After nohup(1) the daemon goes on when the terminal is closed. */
    return before.sa_handler == SIG_IGN || !sigaction(SIGHUP, &action, NULL);
}

static bool load(struct daemon *daemon)
{
    struct dmn_options *options = &daemon->options;
    struct dmn_handles *handles = &daemon->handles;
    struct dmn_picture *picture = &daemon->picture;
    struct rnd_scene_options scene;
    char error[RND_ERROR_SIZE];
    cpu_set_t processors;

    if (!options->render.threads)
        options->render.threads =
            sched_getaffinity(0, sizeof(processors), &processors) ? 1 : CPU_COUNT(&processors);
    /* Check now, not after a night of rendering. */
    if (options->save && !dmn_file_check(options->save, true, error)) return fail(error);
    if (options->tls_key && !(daemon->tls = dmn_tls_load(options->tls_certificate, options->tls_key, error)))
        return fail(error);
    handles->options = options;
    /* Starting this program takes a while, so it comes first. It runs until the film is saved. */
    options->scene.image_program = rnd_image_program_create();
    if (!options->scene.image_program) return fail("out of memory");
    if (!rnd_image_program_start(options->scene.image_program, error)) return fail(error);
    scene = options->scene;
    handles->gaze = dmn_gaze_open(options, error);
    if (!handles->gaze) return fail(error);
    if (options->watch && !(handles->edits = dmn_edits_create(&options->scene, error))) return fail(error);
    scene.textures_later = !options->virtual_clock; /* when textures come differs from run to run */
    daemon->scene = rnd_scene_load(&scene, error);
    if (!daemon->scene) return fail(error);
    handles->render = rnd_render_create(daemon->scene, &options->render, error);
    if (!handles->render) return fail(error);
    dmn_report_scene(rnd_scene_info(daemon->scene), options->scene.path, picture->scene.line,
                     sizeof(picture->scene.line));
    if (!dmn_picture_init(picture, handles->render, options->render.width, options->render.height))
        return fail("out of memory");
    return true;
}

static bool open_sockets(struct daemon *daemon)
{
    const char *token = getenv("FOVEAD_TOKEN");
    char error[PRO_ERROR_SIZE];

    if (token && !*token) token = NULL;
    for (; daemon->listeners < daemon->options.listens; daemon->listeners++) {
        int i = daemon->listeners;

        if (!dmn_listener_init(&daemon->listener[i], &daemon->options.listen[i], token, error))
            return fail(error);
        daemon->listener[i].is_tls = daemon->tls && daemon->listener[i].address.is_http;
    }
    return true;
}

/* Print the address that a listener listens on, and for browsers the address of the page. */
static void print_listener(const struct daemon *daemon, const struct dmn_listener *listener)
{
    const char *host = listener->address.host, *tls = listener->is_tls ? "s" : "";
    char address[PRO_ERROR_SIZE], own[256] = "";
    const bool is_any = !host[strspn(host, "0.:")]; /* as 0.0.0.0 and ::, all addresses of this machine */

    pro_address_print(&listener->address, address, sizeof(address));
    if (!listener->address.is_http) {
        dmn_print(daemon->out, "listens  %s\n", address);
        return;
    }
    dmn_print(daemon->out, "listens  http%s%s\n", tls, address + strlen("http"));
    if (is_any && !gethostname(own, sizeof(own) - 1) && *own)
        snprintf(address, sizeof(address), "http:%s:%u", own, listener->address.port);
    dmn_print(daemon->out, "page     http%s://%s/%s\n", tls, address + strlen("http:"),
              listener->token ? "#token=TOKEN (put the value of FOVEAD_TOKEN for TOKEN)" : "");
}

static void print_viewer(const struct daemon *daemon)
{
    char address[PRO_ERROR_SIZE];

    pro_address_print(&daemon->options.viewer, address, sizeof(address));
    dmn_print(daemon->out, "viewer   %s, as soon as one is there\n", address + strlen("tcp:"));
}

static void print_start(const struct daemon *daemon)
{
    const struct rnd_scene_info *info = rnd_scene_info(daemon->scene);
    const struct dmn_options *options = &daemon->options;
    struct dmn_gaze_status gaze;

    dmn_gaze_status(daemon->handles.gaze, &gaze);
    dmn_report_left_out(info, options->scene.path);
    dmn_print(daemon->out, "scene    %s\n", daemon->picture.scene.line);
    dmn_print(daemon->out, "camera   %.8g,%.8g,%.8g m\n", info->camera[0], info->camera[1], info->camera[2]);
    dmn_print(daemon->out, "gaze     %s\n", gaze.source.description);
    if (*gaze.recording) dmn_print(daemon->out, "records  %s\n", gaze.recording);
    dmn_print(daemon->out, "film     %dx%d, mode %s, %d threads\n", options->render.width,
              options->render.height, options->render.distribution->name, options->render.threads);
    for (int i = 0; i < daemon->listeners; i++) print_listener(daemon, &daemon->listener[i]);
    if (options->has_viewer) print_viewer(daemon);
    dmn_print(daemon->out, "fovead: ready\n");
    fflush(daemon->out);
}

/* Tell a service manager, if there is one (sd_notify(3)). */
static void notify(const char *state)
{
    const char *path = getenv("NOTIFY_SOCKET");
    struct sockaddr_un name = {.sun_family = AF_UNIX};
    int fd;

    if (!path || (*path != '/' && *path != '@') || strlen(path) >= sizeof(name.sun_path)) return;
    memcpy(name.sun_path, path, strlen(path));
    if (*path == '@') name.sun_path[0] = '\0';
    if ((fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) < 0) return;
    sendto(fd, state, strlen(state), MSG_NOSIGNAL, (struct sockaddr *)&name,
           (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(path)));
    close(fd);
}

static void on_tick(void *argument)
{
    struct daemon *daemon = argument;
    struct dmn_gaze_status gaze;
    struct dmn_work work;

    dmn_gaze_status(daemon->handles.gaze, &gaze);
    dmn_report_recording(&daemon->told, &gaze);
    dmn_painter_work(daemon->handles.painter, &work);
    dmn_report_progress(&daemon->bar, &daemon->options, &work);
    if (daemon->options.save_every > 0) dmn_autosave_tick(&daemon->autosave, &daemon->handles);
}

static void on_job_done(void *argument, const struct dmn_job *job)
{
    struct daemon *daemon = argument;

    dmn_autosave_done(&daemon->autosave, job);
}

static bool start(struct daemon *daemon)
{
    struct dmn_handles *handles = &daemon->handles;
    struct dmn_loop_options loop = {
        .handles = handles,
        .picture = &daemon->picture,
        .signal_fd = signal_fd,
        .listener = daemon->listener,
        .listeners = daemon->listeners,
        .tls = daemon->tls,
        .tick = on_tick,
        .job_done = on_job_done,
        .context = daemon,
    };
    struct dmn_painter_options painter = {
        .render = handles->render,
        .gaze = handles->gaze,
        .scene = daemon->scene,
        .pixels = (uint64_t)daemon->options.render.width * (uint64_t)daemon->options.render.height,
        .tiles = daemon->picture.tiles,
        .until = daemon->options.until,
        .virtual_clock = daemon->options.virtual_clock,
        .threads = daemon->options.render.threads,
        .batch_seconds = daemon->options.gaze || daemon->listeners ? STEERED_SECONDS : UNSTEERED_SECONDS,
        .wake = dmn_loop_wake,
        .warn = dmn_report_warnings,
    };
    char error[PRO_ERROR_SIZE];

    daemon->loop = dmn_loop_create(&loop, error);
    if (!daemon->loop) return fail(error);
    painter.context = daemon->loop;
    handles->jobs = dmn_jobs_start(handles, dmn_loop_wake, daemon->loop);
    if (!handles->jobs) return fail("no thread can be made");
    atomic_store(&serving, true);
    if (!daemon->options.virtual_clock && !dmn_gaze_start(handles->gaze, dmn_loop_wake, daemon->loop))
        return fail("no thread can be made");
    handles->painter = dmn_painter_start(&painter);
    if (!handles->painter) return fail("no thread can be made");
    return true;
}

/* Call it after print_start(), which describes the scene as first loaded. */
static bool start_edits(struct daemon *daemon)
{
    struct dmn_handles *handles = &daemon->handles;
    struct dmn_edits_options options = {handles->painter, &daemon->scene, &daemon->picture.scene,
                                        daemon->out,      dmn_loop_wake,  daemon->loop};

    return !handles->edits || dmn_edits_start(handles->edits, &options) || fail("no thread can be made");
}

/* Stop all threads and disconnect all clients; the film then changes no more. */
static void stop(struct daemon *daemon, struct dmn_work *out_work)
{
    struct dmn_handles *handles = &daemon->handles;

    notify("STOPPING=1");
    if (handles->painter) {
        dmn_painter_stop(handles->painter);
        dmn_painter_work(handles->painter, out_work);
        dmn_loop_complete(daemon->loop);
    }
    dmn_edits_stop(handles->edits);
    if (handles->gaze) dmn_gaze_stop(handles->gaze);
    dmn_jobs_destroy(handles->jobs);
    dmn_loop_destroy(daemon->loop);
    while (daemon->listeners > 0) dmn_listener_finish(&daemon->listener[--daemon->listeners]);
    dmn_report_progress_end(&daemon->bar);
}

/* End the recording, if there is one. */
static bool finish_recording(struct daemon *daemon)
{
    struct dmn_gaze_status gaze;
    char text[DMN_TEXT_SIZE];

    dmn_gaze_status(daemon->handles.gaze, &gaze);
    if (!*gaze.recording) return true;
    if (!dmn_gaze_record(daemon->handles.gaze, NULL, false, text)) return fail(text);
    dmn_print(daemon->out, "fovead: %s\n", text);
    return true;
}

static bool finish(struct daemon *daemon, const struct dmn_work *work)
{
    const char *save = daemon->options.save;
    char error[RND_ERROR_SIZE];
    struct dmn_gaze_status gaze;
    bool saved = save && dmn_save_film(daemon->handles.render, save, &daemon->options.exposure, error);
    bool recorded = finish_recording(daemon);

    dmn_gaze_status(daemon->handles.gaze, &gaze);
    dmn_report_summary(&daemon->options, &daemon->picture, work, &gaze, saved);
    return (!save || saved || fail(error)) && recorded;
}

int main(int argc, char **argv)
{
    struct daemon daemon = {0};
    struct dmn_work work = {0};
    bool good;

    dmn_streams_open("fovead");
    switch (dmn_options_parse(argc, argv, &daemon.options)) {
    case DMN_ANSWERED:
        return 0;
    case DMN_REFUSED:
        return 2;
    case DMN_LIST:
        return dmn_list_trackers(daemon.options.json) ? 0 : 1;
    case DMN_RUN:
        break;
    }
    daemon.out = daemon.options.json ? stderr : stdout;
    good = (handle_signals() || fail("cannot handle signals")) && load(&daemon) && open_sockets(&daemon) &&
           start(&daemon);
    if (good) {
        print_start(&daemon);
        good = start_edits(&daemon);
    }
    if (good) {
        notify("READY=1");
        dmn_loop_run(daemon.loop);
    }
    stop(&daemon, &work);
    if (good) good = finish(&daemon, &work);
    dmn_edits_destroy(daemon.handles.edits);
    dmn_tls_destroy(daemon.tls);
    dmn_painter_destroy(daemon.handles.painter);
    dmn_gaze_close(daemon.handles.gaze);
    dmn_picture_finish(&daemon.picture);
    rnd_render_destroy(daemon.handles.render);
    rnd_scene_destroy(daemon.scene);
    rnd_image_program_destroy(daemon.options.scene.image_program);
    return good ? 0 : 1;
}
