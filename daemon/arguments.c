/* What the options of fovead's command line take that is neither a number nor a text. */
#include "arguments.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "image_options.h"
#include "numbers.h"
#include "settings.h"

bool dmn_take_sun(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;
    double n[4];

    (void)out_error;
    if (!dmn_option_numbers(option, text, n) || n[1] < -90 || n[1] > 90 || n[2] < 0 || n[3] < 0 || n[3] > 90)
        return false;
    for (int i = 0; i < 4; i++) out->scene.sun[i] = (float)n[i];
    return out->scene.has_sun = true;
}

bool dmn_take_camera(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;

    (void)out_error;
    return out->scene.has_camera = dmn_option_numbers(option, text, out->scene.camera);
}

bool dmn_take_fov(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;
    double n[2];

    (void)out_error;
    if (!dmn_option_numbers(option, text, n)) return false;
    for (int i = 0; i < 2; i++) out->fov[i] = (float)(n[i] * M_PI / 180);
    return true;
}

bool dmn_take_size(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;
    int width, height;

    (void)option, (void)out_error;
    if (!dmn_parse_size(text, &width, &height) || width % (2 * RND_TILE) || width > RND_MAX_WIDTH ||
        (height && 2 * height != width))
        return false;
    out->render.width = width;
    out->render.height = width / 2;
    return true;
}
_Static_assert(2 * RND_TILE == 128 && RND_MAX_WIDTH == 32768, "the row of --size names other numbers");

bool dmn_take_mode(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;

    (void)option;
    out->render.distribution = rnd_distribution_find(text);
    if (!out->render.distribution) snprintf(out_error, DMN_OPTION_ERROR_SIZE, "there is no '%s'", text);
    return out->render.distribution;
}

const char *dmn_mode_at(size_t index, const char **out_summary)
{
    const struct rnd_distribution *mode = rnd_distribution_at(index);

    *out_summary = mode ? mode->summary : NULL;
    return mode ? mode->name : NULL;
}

/* A source by its index: --gaze takes a source and its argument. */
const char *dmn_gaze_usage_at(size_t index, const char **out_summary)
{
    const struct trk_source_kind *kind = trk_source_kind_at(index);

    *out_summary = kind ? kind->summary : NULL;
    return kind ? kind->usage : NULL;
}

bool dmn_take_listen(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;

    (void)option;
    if (text && !strncmp(text, "https:", strlen("https:"))) {
        snprintf(out_error, DMN_OPTION_ERROR_SIZE, "%.200s: give it as http:%.200s, and --tls CERT,KEY", text,
                 text + strlen("https:"));
        return false;
    }
    if (out->listens == DMN_MAX_LISTEN) {
        snprintf(out_error, DMN_OPTION_ERROR_SIZE, "%d addresses at most", DMN_MAX_LISTEN);
        return false;
    }
    return pro_address_parse(text, &out->listen[out->listens], out_error) && ++out->listens;
}
_Static_assert((int)DMN_OPTION_ERROR_SIZE >= (int)PRO_ERROR_SIZE, "an address's error has no room");

bool dmn_take_tls(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;
    const char *comma = strchr(text, ',');

    (void)option, (void)out_error;
    if (!comma || comma == text || !comma[1] || strchr(comma + 1, ',') ||
        (size_t)(comma - text) >= sizeof(out->tls_certificate))
        return false;
    snprintf(out->tls_certificate, sizeof(out->tls_certificate), "%.*s", (int)(comma - text), text);
    out->tls_key = comma + 1;
    return true;
}

/* HOST or HOST:PORT; an IPv6 address is in brackets. */
bool dmn_take_tev(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;
    const bool has_port = *text == '[' ? strstr(text, "]:") : strchr(text, ':');
    char address[sizeof(out->viewer.host) + 16], error[PRO_ERROR_SIZE];
    const int length = has_port ? snprintf(address, sizeof(address), "tcp:%s", text)
                                : snprintf(address, sizeof(address), "tcp:%s:%d", text, PRO_TEV_PORT);

    (void)option, (void)out_error;
    if ((size_t)length >= sizeof(address) || !text[strspn(text, "0123456789")]) return false;
    return out->has_viewer = pro_address_parse(address, &out->viewer, error);
}
_Static_assert(PRO_TEV_PORT == 14158, "the row of --tev names another port");

bool dmn_take_until(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    (void)option, (void)out_error;
    return dmn_until_parse(text, &((struct dmn_options *)values)->until);
}

bool dmn_take_save(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    return dmn_image_is_named(text) && dmn_take_text(option, text, values, out_error);
}

/* The plane of that name, length bytes of text; -1: there is none. */
static int find_plane(const char *text, size_t length)
{
    const char *name, *summary;

    for (int i = 0; (name = rnd_plane_at((size_t)i, &summary)); i++)
        if (strlen(name) == length && !strncmp(name, text, length)) return i;
    return -1;
}

static bool refuse_plane(const char *text, char *out_error)
{
    const char *name, *summary;

    snprintf(out_error, DMN_OPTION_ERROR_SIZE, "there is no '%.*s', expected all or some of ",
             (int)strcspn(text, ","), text);
    for (size_t i = 0; (name = rnd_plane_at(i, &summary)); i++) {
        const size_t length = strlen(out_error);

        snprintf(out_error + length, DMN_OPTION_ERROR_SIZE - length, "%s%s", i ? "," : "", name);
    }
    return false;
}

bool dmn_take_planes(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    uint32_t *planes = &((struct dmn_options *)values)->render.planes;
    const bool all = !strcmp(text, "all");
    const char *summary;
    size_t length;

    (void)option;
    *planes = 0;
    for (size_t i = 0; all && rnd_plane_at(i, &summary); i++) *planes |= 1u << i;
    for (; !all; text += length + 1) {
        const int plane = find_plane(text, length = strcspn(text, ","));

        if (plane < 0) return refuse_plane(text, out_error);
        *planes |= 1u << plane;
        if (!text[length]) break;
    }
    return true;
}

bool dmn_take_clock(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct dmn_options *out = values;

    (void)option, (void)out_error;
    out->virtual_clock = !strcmp(text, "virtual");
    return out->virtual_clock || !strcmp(text, "real");
}
