/* Fuzzing of HID report descriptors: any bytes are a layout that holds together, or one line of error.
 *
 * As it is built here it is a test of its own (fuzz.h). With libFuzzer:
 *   clang -g -O1 -fsanitize=fuzzer,address,undefined -DLIBFUZZER -D_GNU_SOURCE -Itracker \
 *       tests/fuzz/tracker_descriptor.c tracker/hid_descriptor.c tracker/error.c -lm
 *   ./a.out -runs=50000000 $(mktemp -d) tests/fuzz/corpus/descriptor
 */
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
