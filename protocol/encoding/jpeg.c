/* jpeg.c: tiles as a display shows them: sRGB, exposure 1, JPEG of quality 90 without chroma subsampling.
 *
 * libjpeg reports errors by a callback that must not return; here it jumps out, prints nothing and never
 * exits. While decoding, a warning (data that ends early, bits that make no sense) is an error too: half a
 * tile is no tile.
 */
#include "encoding.h"

#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>

#include <jpeglib.h>

enum { QUALITY = 90, STEPS = 4096 };

/* --- the sRGB curve (IEC 61966-2-1), from tables that are written once and only read from then on --- */

static pthread_once_t once = PTHREAD_ONCE_INIT;
/* 8-bit code + 1/2 at i / STEPS; interpolated, within 0.005 of the curve. */
static float code_table[STEPS + 1];
static float linear_table[256];

static void make_tables(void)
{
    for (int i = 0; i <= STEPS; i++) {
        double x = (double)i / STEPS;
        double y = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
        code_table[i] = (float)(255 * y + 0.5);
    }
    for (int i = 0; i < 256; i++) {
        double y = i / 255.0;
        linear_table[i] = (float)(y <= 0.04045 ? y / 12.92 : pow((y + 0.055) / 1.055, 2.4));
    }
}

static uint8_t code_from_linear(float x)
{
    if (!(x > 0)) return 0; /* NaN too */
    if (x >= 1) return 255;
    float at = x * STEPS;
    int i = (int)at;
    return (uint8_t)(code_table[i] + (at - (float)i) * (code_table[i + 1] - code_table[i]));
}

/* --- libjpeg --- */

struct failure {
    struct jpeg_error_mgr manager; /* first, so that libjpeg's pointer to it is one to this */
    jmp_buf jump;
};

static void fail(j_common_ptr jpeg)
{
    struct failure *failure = (struct failure *)jpeg->err;
    longjmp(failure->jump, 1);
}

static void fail_on_warning(j_common_ptr jpeg, int level)
{
    if (level < 0) fail(jpeg);
}

static void print_nothing(j_common_ptr jpeg)
{
    (void)jpeg;
}

static struct jpeg_error_mgr *silence(struct failure *failure)
{
    jpeg_std_error(&failure->manager);
    failure->manager.error_exit = fail;
    failure->manager.emit_message = fail_on_warning;
    failure->manager.output_message = print_nothing;
    return &failure->manager;
}

/* Variables that must outlive the jump; locals do not. */
struct output {
    uint8_t *bytes;
    unsigned long count;
};

static bool compress(const uint8_t *pixels, unsigned size, struct output *output)
{
    struct jpeg_compress_struct jpeg = {0};
    struct failure failure;
    jpeg.err = silence(&failure);
    if (setjmp(failure.jump)) {
        jpeg_destroy_compress(&jpeg);
        return false;
    }
    jpeg_create_compress(&jpeg);
    jpeg_mem_dest(&jpeg, &output->bytes, &output->count);
    jpeg.image_width = jpeg.image_height = size;
    jpeg.input_components = 3;
    jpeg.in_color_space = JCS_RGB;
    jpeg_set_defaults(&jpeg);
    jpeg_set_quality(&jpeg, QUALITY, TRUE);
    jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1; /* 4:4:4 */
    jpeg_start_compress(&jpeg, TRUE);
    while (jpeg.next_scanline < size) {
        JSAMPROW row = (JSAMPROW)pixels + (size_t)jpeg.next_scanline * size * 3;
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    return true;
}

static uint8_t *encode(const float *rgb, unsigned size, size_t *out_count)
{
    pthread_once(&once, make_tables);
    size_t values = (size_t)size * size * 3;
    /* TurboJPEG's bound for 4:4:4; libjpeg would grow the buffer itself, but leaks it if it fails later. */
    size_t padded = (size + 7) & ~7u;
    size_t bound = padded * padded * 6 + 2048;
    uint8_t *pixels = malloc(values);
    uint8_t *bytes = malloc(bound);
    struct output output = {bytes, bound};
    if (!pixels || !bytes) goto fail;
    for (size_t i = 0; i < values; i++) pixels[i] = code_from_linear(rgb[i]);
    if (!compress(pixels, size, &output) || output.bytes != bytes) goto fail;
    free(pixels);
    uint8_t *exact = realloc(bytes, output.count);
    *out_count = output.count;
    return exact ? exact : bytes;
fail:
    if (output.bytes != bytes) free(output.bytes);
    free(bytes);
    free(pixels);
    return NULL;
}

static bool decompress(const uint8_t *bytes, size_t count, unsigned size, uint8_t *pixels)
{
    struct jpeg_decompress_struct jpeg = {0};
    struct failure failure;
    jpeg.err = silence(&failure);
    if (setjmp(failure.jump)) {
        jpeg_destroy_decompress(&jpeg);
        return false;
    }
    jpeg_create_decompress(&jpeg);
    jpeg_mem_src(&jpeg, bytes, count);
    jpeg_read_header(&jpeg, TRUE);
    /* A file of many scans can cost a hundred thousand times its bytes to decode. */
    bool ok = jpeg.image_width == size && jpeg.image_height == size && jpeg.num_components == 3 &&
              !jpeg_has_multiple_scans(&jpeg);
    if (ok) {
        jpeg.out_color_space = JCS_RGB;
        jpeg_start_decompress(&jpeg);
        while (jpeg.output_scanline < size) {
            JSAMPROW row = pixels + (size_t)jpeg.output_scanline * size * 3;
            jpeg_read_scanlines(&jpeg, &row, 1);
        }
        jpeg_finish_decompress(&jpeg);
        ok = jpeg.src->bytes_in_buffer == 0;
    }
    jpeg_destroy_decompress(&jpeg);
    return ok;
}

static bool decode(const uint8_t *bytes, size_t count, unsigned size, float *out_rgb)
{
    pthread_once(&once, make_tables);
    size_t values = (size_t)size * size * 3;
    uint8_t *pixels = malloc(values);
    if (!pixels) return false;
    bool ok = decompress(bytes, count, size, pixels);
    for (size_t i = 0; ok && i < values; i++) out_rgb[i] = linear_table[pixels[i]];
    free(pixels);
    return ok;
}

const struct pro_codec pro_jpeg = {FOVEA__ENCODING__ENCODING_JPEG, encode, decode};
