/* The test bed: plugging, unplugging, and the threads that send. */
#include "fake_internal.h"

#include <fcntl.h>
#include <pty.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

const char *const fake_kind_names[FAKE_KINDS] = {"still",  "hid",   "unready",    "garbage",
                                                 "broken", "psvr2", "psvr2-late", "psvr2-stuck"};

static void die(const char *what, GError *error)
{
    fprintf(stderr, "fake tracker: %s%s%s\n", what, error ? ": " : "", error ? error->message : "");
    exit(2);
}

uint64_t fake_now_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000000 + (uint64_t)now.tv_nsec;
}

/* A kernel does not wait for programs that compute. Without the right to this priority, the bed is as fast as
 * it can be. */
void fake_be_urgent(void)
{
    static _Thread_local bool is_urgent;
    struct sched_param urgent = {.sched_priority = 1};
    if (!is_urgent) pthread_setschedparam(pthread_self(), SCHED_FIFO, &urgent);
    is_urgent = true;
}

UMockdevIoctlData *fake_ioctl_data(UMockdevIoctlClient *client)
{
    unsigned long request = umockdev_ioctl_client_get_request(client);
    return umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, _IOC_SIZE(request), NULL);
}

static bool is_usb(const struct fake_device *device)
{
    return device->kind >= FAKE_PSVR2;
}

/* --- sending --- */

static void send_one(struct fake_device *device)
{
    /* Like the kernel, keep at most 64 reports that nobody has read. */
    if (g_queue_get_length(&device->reports) == 64) return;
    struct fake_report *report = g_new0(struct fake_report, 1);
    if (is_usb(device))
        fake_usb_fill(device, report);
    else
        fake_hid_fill(device, report);
    device->sent_ns[device->sent++ % FAKE_SENT] = fake_now_ns();
    g_queue_push_tail(&device->reports, report);
    if (is_usb(device))
        fake_usb_pump(device);
    else if (write(device->pty, "", 1) != 1)
        perror("fake tracker: pty");
}

static void *stream(void *argument)
{
    struct fake_device *device = argument;
    fake_be_urgent();
    uint64_t next_ns = fake_now_ns(), period_ns = (uint64_t)(1e9 / device->hz);
    for (bool gone = false; !gone;) {
        next_ns += period_ns;
        struct timespec next = {.tv_sec = (time_t)(next_ns / 1000000000),
                                .tv_nsec = (long)(next_ns % 1000000000)};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
        pthread_mutex_lock(&device->lock);
        /* Send nothing before the device is opened: a tracker rests until a program asks for reports. */
        if (!device->gone && device->starts > device->stops) send_one(device);
        gone = device->gone;
        pthread_mutex_unlock(&device->lock);
    }
    return NULL;
}

/* --- plugging --- */

static char *path_in_bed(const struct fake *fake, const char *node)
{
    char *root = umockdev_testbed_get_root_dir(fake->bed), *path = g_strconcat(root, node, NULL);
    g_free(root);
    return path;
}

/* Make a pseudo-terminal in place of the node that umockdev would make. Returns our end, and the program's
 * end in *out_theirs. */
static int make_node(const struct fake *fake, const char *node, int *out_theirs)
{
    int ours, theirs;
    char name[128];
    struct termios settings;
    if (openpty(&ours, &theirs, name, NULL, NULL) != 0) die("no pseudo-terminal", NULL);
    tcgetattr(theirs, &settings);
    cfmakeraw(&settings);
    tcsetattr(theirs, TCSANOW, &settings);
    fcntl(ours, F_SETFD, FD_CLOEXEC);
    fcntl(theirs, F_SETFD, FD_CLOEXEC);
    fcntl(theirs, F_SETFL, O_NONBLOCK);
    *out_theirs = theirs;
    char *path = path_in_bed(fake, node), *folder = g_path_get_dirname(path);
    g_mkdir_with_parents(folder, 0755);
    unlink(path);
    if (symlink(name, path) != 0) die("no link in the bed", NULL);
    g_free(folder);
    g_free(path);
    return ours;
}

struct fake_device *fake_plug(struct fake *fake, enum fake_kind kind, double hz)
{
    struct fake_device *device = g_new0(struct fake_device, 1);
    GError *error = NULL;
    GString *text = g_string_new(NULL);
    device->fake = fake;
    device->kind = kind;
    device->hz = hz;
    device->number = fake->number++;
    pthread_mutex_init(&device->lock, NULL);
    if (is_usb(device))
        fake_usb_describe(device, text);
    else
        fake_hid_describe(device, text);
    device->pty = make_node(fake, device->node, &device->read_end);
    device->handler = umockdev_ioctl_base_new();
    if (is_usb(device)) {
        g_signal_connect(device->handler, "handle-ioctl", G_CALLBACK(fake_usb_ioctl), device);
        g_signal_connect(device->handler, "client-vanished", G_CALLBACK(fake_usb_vanish), device);
    } else {
        g_signal_connect(device->handler, "handle-ioctl", G_CALLBACK(fake_hid_ioctl), device);
        g_signal_connect(device->handler, "handle-read", G_CALLBACK(fake_hid_read), device);
    }
    /* Make the node first: adding to sysfs announces the device, and a program may open it at once. */
    if (!umockdev_testbed_attach_ioctl(fake->bed, device->node, device->handler, &error))
        die("attach", error);
    if (!umockdev_testbed_add_from_string(fake->bed, text->str, &error)) die("test bed", error);
    g_string_free(text, TRUE);
    if (pthread_create(&device->thread, NULL, stream, device) != 0) die("no thread", NULL);
    g_ptr_array_add(fake->devices, device);
    return device;
}

void fake_unplug(struct fake_device *device)
{
    struct fake *fake = device->fake;
    pthread_mutex_lock(&device->lock);
    bool was_gone = device->gone;
    device->gone = true;
    pthread_mutex_unlock(&device->lock);
    if (was_gone) return;
    pthread_join(device->thread, NULL);
    pthread_mutex_lock(&device->lock);
    if (is_usb(device)) fake_usb_pump(device);
    close(device->pty); /* a program that waits for the node sees a hang-up */
    close(device->read_end);
    pthread_mutex_unlock(&device->lock);
    char *path = path_in_bed(fake, device->node);
    unlink(path);
    g_free(path);
    for (int i = device->systems - 1; i >= 0; i--) {
        if (i == 0 || i == device->systems - 1)
            umockdev_testbed_uevent(fake->bed, device->system[i], "remove");
        umockdev_testbed_remove_device(fake->bed, device->system[i]);
    }
}

uint64_t fake_taken(struct fake_device *device)
{
    pthread_mutex_lock(&device->lock);
    uint64_t taken = device->taken;
    pthread_mutex_unlock(&device->lock);
    return taken;
}

void fake_make_ready(struct fake_device *device)
{
    pthread_mutex_lock(&device->lock);
    device->ready = true;
    pthread_mutex_unlock(&device->lock);
}

uint64_t fake_sent_ns(struct fake_device *device, uint64_t n)
{
    pthread_mutex_lock(&device->lock);
    bool is_kept = n < device->sent && device->sent - n <= FAKE_SENT;
    uint64_t sent_ns = is_kept ? device->sent_ns[n % FAKE_SENT] : 0;
    pthread_mutex_unlock(&device->lock);
    return sent_ns;
}

void fake_requests(struct fake_device *device, unsigned *out_start, unsigned *out_stop,
                   size_t *out_calibration)
{
    pthread_mutex_lock(&device->lock);
    *out_start = device->starts;
    *out_stop = device->stops;
    *out_calibration = device->calibration;
    pthread_mutex_unlock(&device->lock);
}

/* --- the bed --- */

static void *run_loop(void *argument)
{
    fake_be_urgent();
    g_main_loop_run(argument);
    return NULL;
}

struct fake *fake_create(void)
{
    struct fake *fake = g_new0(struct fake, 1);
    fake->bed = umockdev_testbed_new();
    if (!fake->bed) die("no test bed", NULL);
    fake->devices = g_ptr_array_new();
    fake->loop = g_main_loop_new(NULL, FALSE);
    if (pthread_create(&fake->thread, NULL, run_loop, fake->loop) != 0) die("no thread", NULL);
    return fake;
}

static void free_device(gpointer data, gpointer unused)
{
    (void)unused;
    struct fake_device *device = data;
    fake_unplug(device);
    g_object_unref(device->handler);
    g_queue_clear_full(&device->reports, g_free);
    fake_usb_finish(device);
    pthread_mutex_destroy(&device->lock);
    g_free(device);
}

void fake_destroy(struct fake *fake)
{
    for (guint i = 0; i < fake->devices->len; i++) fake_unplug(fake->devices->pdata[i]);
    g_main_loop_quit(fake->loop);
    pthread_join(fake->thread, NULL);
    g_main_loop_unref(fake->loop);
    g_object_unref(fake->bed); /* this ends its thread, which calls our functions */
    g_ptr_array_foreach(fake->devices, free_device, NULL);
    g_ptr_array_free(fake->devices, TRUE);
    g_free(fake);
}
