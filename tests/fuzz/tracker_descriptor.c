/* Fuzzing of HID report descriptors: any bytes are a layout that holds together, or one line of error. See
 * fuzz.h. */
#include "fuzz.h"

#include "hid_descriptor.h"

#include "../device/descriptors.h"

#include <math.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct trk_hid_layout layout;
    char error[TRK_ERROR_SIZE] = "";
    if (!trk_hid_parse(data, size, &layout, error)) {
        if (*error == '\0' || strchr(error, '\n')) abort();
        return 0;
    }
    if (*error || layout.fields > TRK_HID_MAX_FIELDS) abort();
    for (size_t i = 0; i < layout.fields; i++) {
        const struct trk_hid_field *field = &layout.field[i];
        if (field->bits < 1 || field->bits > 64) abort();
        if ((unsigned)field->first_bit + field->bits > layout.bits[field->type][field->report]) abort();
        if (!isfinite(field->scale) || !isfinite(field->offset)) abort();
        if (field->has_range && field->low >= field->high) abort();
        if (field->report && !layout.numbered) abort();
    }
    if (!trk_hid_find(&layout, TRK_HID_INPUT, TRK_HID_GAZE_X)) abort();
    return 0;
}

#ifndef LIBFUZZER
int main(void)
{
    return fuzz_run_corpus(CORPUS, 200000);
}
#endif
