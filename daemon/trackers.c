/* fovead --list-trackers: what eye trackers there are, for people and for scripts. */
#include <stdio.h>
#include <stdlib.h>

#include <jansson.h>

#include "tracker.h"
#include "print.h"
#include "trackers.h"

enum { MOST = 64 };

static void print_table(const struct trk_device_info *devices, size_t count)
{
    if (!count) puts("no eye tracker is plugged in");
    for (size_t i = 0; i < count; i++) {
        const struct trk_device_info *device = &devices[i];

        dmn_print(stdout, "%s\n", device->name);
        dmn_print(stdout, "    use it      --gaze %s\n", device->source);
        if (*device->abilities) dmn_print(stdout, "    can do      %s\n", device->abilities);
        if (*device->problem) dmn_print(stdout, "    problem     %s\n", device->problem);
    }
}

static void print_json(const struct trk_device_info *devices, size_t count)
{
    json_t *list = json_array(), *object = json_pack("{s:o}", "trackers", list);

    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_pack("{s:s, s:s, s:s, s:s}", "gaze", devices[i].source, "name",
                                              devices[i].name, "abilities", devices[i].abilities, "problem",
                                              devices[i].problem));
    if (object) json_dumpf(object, stdout, JSON_INDENT(2));
    if (object) putchar('\n');
    json_decref(object);
}

bool dmn_list_trackers(bool json)
{
    struct trk_device_info *devices = calloc(MOST, sizeof(*devices));
    size_t count;

    if (!devices) {
        fputs("fovead: out of memory\n", stderr);
        return false;
    }
    count = trk_list(devices, MOST);
    (json ? print_json : print_table)(devices, count < MOST ? count : MOST);
    free(devices);
    return true;
}
