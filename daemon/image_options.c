/* What command lines and requests say about files of pictures. */
#include <string.h>

#include "image_options.h"

bool dmn_image_is_named(const char *path)
{
    static const char *const ENDS[] = {".exr", ".png", ".jpg", ".jpeg"};
    const char *dot = strrchr(path, '.');

    for (size_t i = 0; dot && i < sizeof(ENDS) / sizeof(*ENDS); i++)
        if (!strcasecmp(dot, ENDS[i])) return true;
    return false;
}

bool dmn_image_is_exr(const char *path)
{
    const char *dot = strrchr(path, '.');

    return dot && !strcasecmp(dot, ".exr");
}

bool dmn_take_exposure(const struct dmn_option *option, const char *text, void *values, char *out_error)
{
    struct rnd_exposure *out = (struct rnd_exposure *)((char *)values + option->target);

    (void)out_error;
    out->automatic = !strcmp(text, "auto");
    return out->automatic || dmn_option_numbers(option, text, &out->stops);
}
