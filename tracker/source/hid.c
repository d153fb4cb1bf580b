/* Eye trackers on HID: usage page 0x12 "Eye and Head Trackers", through hidapi on hidraw. */
#include "source/device.h"

#include "error.h"
#include "hid_report.h"
#include "source/kinds.h"
#include "system.h"

#include <errno.h>
#include <fcntl.h>
#include <hidapi.h>
#include <linux/hidraw.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { PAGE = 0x12, EYE_TRACKER = 0x01, MAX_NODES = 16, MAX_REPORT = 1 + TRK_HID_MAX_REPORT_BITS / 8 };

/* The screen of a usual desk: 24 inches, 16:9. */
static const struct trk_screen usual_screen = {.width_m = 0.531f, .height_m = 0.299f, .distance_m = 0.65f};
static const double smallest_m = 0.01, largest_m = 20, fastest_hz = 20000;

/* If a device takes longer than this to answer a request, no more requests are sent. */
static const uint64_t slow_ns = 1000000000;

static const char no_access[] =
    "%s (%s): %s; install 70-fovead.rules into /etc/udev/rules.d or /lib/udev/rules.d, add a line "
    "for %04x:%04x if it has none, and plug it in again";

struct node { /* an eye tracker's device node */
    char path[256], name[160];
    uint16_t vendor, product;
};

struct hid {
    struct trk_device *device;
    hid_device *handle;
    struct trk_hid_layout layout;
    struct trk_screen screen;
    uint8_t gaze_report; /* id of the report with gaze */
    bool has_clock;
    struct trk_hid_values features; /* all features that were read when it was opened */
    uint8_t report[MAX_REPORT];
};

/* For hidapi, which keeps its last error and whether it was initialised in global variables. */
static pthread_mutex_t hidapi_lock = PTHREAD_MUTEX_INITIALIZER;

/* --- finding --- */

/* Append a name that the device states in any script. Characters that are not printable ASCII become '?'. */
static void append_name(char *out, size_t size, const wchar_t *text)
{
    size_t length = strlen(out);
    if (!text) return;
    if (length && length + 1 < size) out[length++] = ' ';
    for (; *text && length + 1 < size; text++)
        out[length++] = *text >= ' ' && *text <= '~' ? (char)*text : '?';
    out[length] = '\0';
}

/* hidapi lists one entry per collection. Find those of eye trackers, each path once. */
static size_t find_nodes(struct node out_nodes[MAX_NODES])
{
    size_t nodes = 0;
    pthread_mutex_lock(&hidapi_lock);
    struct hid_device_info *all = hid_enumerate(0, 0);
    for (struct hid_device_info *at = all; at && nodes < MAX_NODES; at = at->next) {
        if (at->usage_page != PAGE || at->usage != EYE_TRACKER || strlen(at->path) >= sizeof out_nodes->path)
            continue;
        bool is_new = true;
        for (size_t i = 0; i < nodes; i++) is_new &= strcmp(out_nodes[i].path, at->path) != 0;
        if (!is_new) continue;
        struct node *node = &out_nodes[nodes++];
        *node = (struct node){.vendor = at->vendor_id, .product = at->product_id};
        strcpy(node->path, at->path);
        append_name(node->name, sizeof node->name, at->manufacturer_string);
        append_name(node->name, sizeof node->name, at->product_string);
        if (!*node->name)
            snprintf(node->name, sizeof node->name, "HID %04x:%04x", node->vendor, node->product);
    }
    hid_free_enumeration(all);
    pthread_mutex_unlock(&hidapi_lock);
    return nodes;
}

/* Read the report descriptor, which hidapi 0.13 cannot. sysfs needs no permission and does not disturb the
 * device; the ioctl is for systems without sysfs. */
static ssize_t read_descriptor(const char *path, uint8_t out[TRK_HID_MAX_DESCRIPTOR])
{
    char name[320];
    snprintf(name, sizeof name, "/sys/class/hidraw/%s/device/report_descriptor",
             strrchr(path, '/') ? strrchr(path, '/') + 1 : path);
    int file = open(name, O_RDONLY | O_CLOEXEC);
    ssize_t size = file < 0 ? -1 : 0, got;
    while (size >= 0 && size < TRK_HID_MAX_DESCRIPTOR &&
           (got = read(file, out + size, (size_t)(TRK_HID_MAX_DESCRIPTOR - size))) > 0)
        size += got;
    if (file >= 0) close(file);
    if (size > 0) return size;

    struct hidraw_report_descriptor descriptor = {0};
    int bytes = 0;
    file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) return -1;
    size = -1;
    if (ioctl(file, HIDIOCGRDESCSIZE, &bytes) >= 0 && bytes > 0 && bytes <= HID_MAX_DESCRIPTOR_SIZE) {
        descriptor.size = (uint32_t)bytes;
        if (ioctl(file, HIDIOCGRDESC, &descriptor) >= 0) {
            memcpy(out, descriptor.value, (size_t)bytes);
            size = bytes;
        }
    }
    close(file);
    return size;
}

static bool learn_layout(const struct node *node, hid_device *handle, struct trk_hid_layout *out_layout,
                         char out_error[TRK_ERROR_SIZE])
{
    uint8_t bytes[TRK_HID_MAX_DESCRIPTOR];
    char why[TRK_ERROR_SIZE];
    ssize_t size = -1;
#if HID_API_VERSION >= HID_API_MAKE_VERSION(0, 14, 0)
    if (handle) size = hid_get_report_descriptor(handle, bytes, sizeof bytes);
#else
    (void)handle;
#endif
    if (size <= 0) size = read_descriptor(node->path, bytes);
    if (size <= 0)
        return trk_fail(out_error, "%s (%s): its report descriptor cannot be read", node->path, node->name);
    if (trk_hid_parse(bytes, (size_t)size, out_layout, why)) return true;
    return trk_fail(out_error, "%s (%s): %.200s", node->path, node->name, why);
}

static bool may_open(const struct node *node, char out_error[TRK_ERROR_SIZE])
{
    if (access(node->path, R_OK | W_OK) == 0) return true;
    return trk_fail(out_error, no_access, node->path, node->name, strerror(errno), node->vendor,
                    node->product);
}

static void describe_abilities(const struct trk_hid_layout *layout, char *out, size_t size)
{
    bool eyes = trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_LEFT_X) &&
                trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_RIGHT_X);
    bool head = trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_HEAD_X) &&
                trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_TURN_X);
    snprintf(out, size, "gaze point on a screen%s%s%s%s", eyes ? ", eye positions" : "",
             head ? ", head pose" : "",
             layout->has_unknown_turn ? ", head position (the unit of its rotation is not an angle)" : "",
             trk_hid_find(layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP) ? ", device clock" : "");
}

static size_t hid_list(struct trk_device_info *out_devices, size_t room)
{
    struct node nodes[MAX_NODES];
    size_t count = find_nodes(nodes);
    for (size_t i = 0; i < count && i < room; i++) {
        struct trk_device_info *info = &out_devices[i];
        struct trk_hid_layout layout;
        memset(info, 0, sizeof *info);
        snprintf(info->source, sizeof info->source, "hid:%.255s", nodes[i].path);
        snprintf(info->name, sizeof info->name, "%.140s (%04x:%04x)", nodes[i].name, nodes[i].vendor,
                 nodes[i].product);
        if (!learn_layout(&nodes[i], NULL, &layout, info->problem)) continue;
        describe_abilities(&layout, info->abilities, sizeof info->abilities);
        may_open(&nodes[i], info->problem);
    }
    return count;
}

/* --- opening --- */

/* Read each feature report that holds a known quantity once. A device need not answer. */
static void read_features(struct hid *hid)
{
    const struct trk_hid_layout *layout = &hid->layout;
    bool asked[256] = {false};
    for (size_t i = 0; i < layout->fields; i++) {
        const struct trk_hid_field *field = &layout->field[i];
        if (field->type != TRK_HID_FEATURE || field->quantity == TRK_HID_MODE || asked[field->report])
            continue;
        asked[field->report] = true;
        memset(hid->report, 0, sizeof hid->report);
        hid->report[0] = field->report;
        uint64_t start_ns = trk_now_ns();
        int size = hid_get_feature_report(hid->handle, hid->report,
                                          1u + (layout->bits[TRK_HID_FEATURE][field->report] + 7u) / 8);
        struct trk_hid_values values;
        /* The first byte is an id even if reports are not numbered. */
        size_t skip = !layout->numbered;
        if (size > 0 &&
            trk_hid_decode(layout, TRK_HID_FEATURE, hid->report + skip, (size_t)size - skip, &values))
            for (int q = 0; q < TRK_HID_QUANTITIES; q++)
                if (values.has >> q & 1) {
                    hid->features.value[q] = values.value[q];
                    hid->features.has |= UINT32_C(1) << q;
                }
        if (trk_now_ns() - start_ns > slow_ns) return;
    }
}

/* Ask for everything that the device can send, or for nothing. A device may not know the request and send
 * anyway. */
static void request_mode(struct hid *hid, uint64_t mode)
{
    const struct trk_hid_field *field = trk_hid_find(&hid->layout, TRK_HID_FEATURE, TRK_HID_MODE);
    if (!field) return;
    size_t size = 1u + (hid->layout.bits[TRK_HID_FEATURE][field->report] + 7u) / 8;
    memset(hid->report, 0, size);
    if (trk_hid_encode(field, mode, hid->report, size) ||
        trk_hid_encode(field, mode & TRK_HID_ASK_GAZE, hid->report, size))
        hid_send_feature_report(hid->handle, hid->report, size);
}

static double feature(const struct hid *hid, enum trk_hid_quantity quantity)
{
    return hid->features.has >> quantity & 1 ? hid->features.value[quantity] : 0;
}

/* Take the screen from the options, else from the device, else a usual one. Returns which of them it is. */
static const char *choose_screen(struct hid *hid, const struct trk_screen *wanted)
{
    double width_m = feature(hid, TRK_HID_WIDTH), height_m = feature(hid, TRK_HID_HEIGHT);
    bool is_sane =
        width_m >= smallest_m && width_m <= largest_m && height_m >= smallest_m && height_m <= largest_m;
    bool is_wanted = wanted->width_m > 0 && wanted->height_m > 0;
    hid->screen = usual_screen;
    if (is_sane) hid->screen = (struct trk_screen){(float)width_m, (float)height_m, usual_screen.distance_m};
    if (is_wanted)
        hid->screen = (struct trk_screen){wanted->width_m, wanted->height_m, usual_screen.distance_m};
    if (wanted->distance_m > 0) hid->screen.distance_m = wanted->distance_m;
    return is_wanted ? "as given" : is_sane ? "calibrated" : "assumed";
}

static const char *status_remark(double status)
{
    switch ((int)status) {
    case TRK_HID_CONFIGURING:
        return "it is being configured";
    case TRK_HID_NEEDS_SCREEN:
        return "it asks for its screen to be set up";
    case TRK_HID_NEEDS_USER:
        return "it asks for the user to be calibrated";
    default:
        return "";
    }
}

static double sane_rate(double rate_hz)
{
    return rate_hz >= 1 && rate_hz <= fastest_hz ? rate_hz : 0;
}

static void tell_facts(struct hid *hid, const struct node *node, const char *whose,
                       struct trk_device_facts *out_facts)
{
    const struct trk_hid_field *gaze = trk_hid_find(&hid->layout, TRK_HID_INPUT, TRK_HID_GAZE_X);
    const struct trk_hid_field *clock = trk_hid_find(&hid->layout, TRK_HID_INPUT, TRK_HID_TIMESTAMP);
    char rate[32] = "";
    hid->gaze_report = gaze->report;
    hid->has_clock = clock && clock->report == gaze->report;
    out_facts->on_screen = true;
    out_facts->rate_hz = sane_rate(feature(hid, TRK_HID_FREQUENCY));
    if (hid->has_clock) {
        out_facts->clock_bits = trk_hid_clock_bits(clock);
        out_facts->tick_ns = clock->scale * 1e9;
    }
    if (out_facts->rate_hz > 0) snprintf(rate, sizeof rate, ", %.0f Hz", out_facts->rate_hz);
    snprintf(out_facts->remark, sizeof out_facts->remark, "%s", status_remark(feature(hid, TRK_HID_STATUS)));
    snprintf(out_facts->description, sizeof out_facts->description,
             "%.100s on %.64s: screen of %.0f x %.0f mm (%s) at %.2f m%s", node->name, node->path,
             (double)hid->screen.width_m * 1000, (double)hid->screen.height_m * 1000, whose,
             (double)hid->screen.distance_m, rate);
}

static void hid_detach(void *handle)
{
    struct hid *hid = handle;
    request_mode(hid, 0);
    pthread_mutex_lock(&hidapi_lock);
    hid_close(hid->handle);
    pthread_mutex_unlock(&hidapi_lock);
    free(hid);
}

static struct hid *open_node(const struct node *node, struct trk_device *device,
                             const struct trk_source_options *options, struct trk_device_facts *out_facts,
                             char out_error[TRK_ERROR_SIZE])
{
    if (!may_open(node, out_error)) return NULL;
    struct hid *hid = calloc(1, sizeof *hid);
    if (!hid) {
        trk_fail(out_error, "%s: no memory", node->path);
        return NULL;
    }
    hid->device = device;
    pthread_mutex_lock(&hidapi_lock);
    hid->handle = hid_open_path(node->path);
    pthread_mutex_unlock(&hidapi_lock);
    if (!hid->handle) {
        trk_fail(out_error, "%s (%s): cannot be opened", node->path, node->name);
        goto fail;
    }
    if (!learn_layout(node, hid->handle, &hid->layout, out_error)) goto fail;
    read_features(hid);
    tell_facts(hid, node, choose_screen(hid, &options->screen), out_facts);
    request_mode(hid, TRK_HID_ASK_GAZE | TRK_HID_ASK_EYES | TRK_HID_ASK_HEAD);
    return hid;
fail:
    pthread_mutex_lock(&hidapi_lock);
    if (hid->handle) hid_close(hid->handle);
    pthread_mutex_unlock(&hidapi_lock);
    free(hid);
    return NULL;
}

static void *hid_attach(struct trk_device *device, const char *path, const struct trk_source_options *options,
                        struct trk_device_facts *out_facts, char out_error[TRK_ERROR_SIZE])
{
    struct node nodes[MAX_NODES];
    char error[TRK_ERROR_SIZE];
    size_t count = find_nodes(nodes);
    bool is_there = false;
    for (size_t i = 0; i < count; i++) {
        if (path && strcmp(path, nodes[i].path) != 0) continue;
        is_there = true;
        struct hid *hid = open_node(&nodes[i], device, options, out_facts, error);
        if (hid) return hid;
        if (!*out_error) memcpy(out_error, error, sizeof error);
    }
    if (path && !is_there && access(path, F_OK) == 0)
        trk_fail(out_error, "%.256s: no eye tracker (none of its HID usages is page 0x12, usage 1)", path);
    return NULL;
}

/* --- reading --- */

static void take_report(struct hid *hid, size_t size, uint64_t arrival_ns)
{
    struct trk_hid_values values;
    if (!trk_hid_decode(&hid->layout, TRK_HID_INPUT, hid->report, size, &values)) return;
    bool says_status = values.has >> TRK_HID_STATUS & 1, says_rate = values.has >> TRK_HID_FREQUENCY & 1;
    if (says_status || says_rate)
        trk_device_news(hid->device, says_rate ? sane_rate(values.value[TRK_HID_FREQUENCY]) : 0,
                        says_status ? status_remark(values.value[TRK_HID_STATUS]) : NULL);
    if (hid->layout.numbered && hid->report[0] != hid->gaze_report) return;
    struct trk_sample sample = {0};
    trk_hid_sample(&values, &hid->screen, &sample);
    trk_device_deliver(hid->device, &sample, values.ticks, arrival_ns);
}

static bool hid_step(void *handle, int wait_ms)
{
    struct hid *hid = handle;
    errno = 0;
    int size = hid_read_timeout(hid->handle, hid->report, sizeof hid->report, wait_ms);
    if (size > 0) take_report(hid, (size_t)size, trk_now_ns());
    return size >= 0 || errno == EINTR;
}

const struct trk_source_row trk_hid = {
    .kind = {.name = "hid",
             .usage = "hid[:PATH]",
             .summary = "a HID eye tracker: the first one, or that at PATH (/dev/hidrawN)",
             .is_device = true,
             .takes_screen = true,
             .follows_eye = true,
             .needs_real_clock = true},
    .list = hid_list,
    .attach = hid_attach,
    .step = hid_step,
    .detach = hid_detach,
};
