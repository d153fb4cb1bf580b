/* Fuzzing of the picture that a client puts together: whatever film and tiles a daemon sends, the picture has
 * the size of the film and is finite.
 *
 * An input is a stream of frames, as client.c takes them: a Welcome begins a picture, and tiles go into it.
 * See fuzz.h. */
#include "fuzz.h"

#include "internal.h"

#include <math.h>

enum { MOST_PIXELS = 1 << 20 }; /* largest picture whose pixels are checked */

static void look(const struct pro_picture *picture, const Fovea__Welcome *film)
{
    const size_t pixels = (size_t)film->width * film->height;
    const double coverage = pro_picture_coverage(picture);
    if (!(coverage >= 0 && coverage <= 1)) abort();
    if (pixels > MOST_PIXELS) return;
    float *rgb = malloc(pixels * 3 * sizeof *rgb);
    if (!rgb) abort();
    for (size_t i = 0; i < 3 * pixels; i++) rgb[i] = NAN;
    pro_picture_resolve(picture, rgb);
    for (size_t i = 0; i < 3 * pixels; i++)
        if (!isfinite(rgb[i])) abort();
    free(rgb);
}

/* Check that the picture has a place for the tile if and only if its first pixel is one of the level. */
static bool has_place(const struct pro_picture *picture, const Fovea__Welcome *film, uint32_t level,
                      uint32_t x, uint32_t y)
{
    const uint64_t left = (uint64_t)x * film->tile_size, top = (uint64_t)y * film->tile_size;
    const bool has = level < film->levels && left << level < film->width && top << level < film->height;
    if (pro_picture_has_place(picture, level, x, y) != has) abort();
    return has;
}

static void put(struct pro_picture *picture, const Fovea__Welcome *film, const Fovea__Tile *tile)
{
    has_place(picture, film, tile->level, tile->x + 1, tile->y);
    has_place(picture, film, tile->level, tile->x, tile->y + 1);
    has_place(picture, film, tile->level + 1, tile->x, tile->y);
    if (!has_place(picture, film, tile->level, tile->x, tile->y)) return;
    float *rgb = malloc((size_t)film->tile_size * film->tile_size * 3 * sizeof *rgb);
    if (!rgb) abort();
    if (pro_decode(tile->encoding, tile->data.data, tile->data.len, film->tile_size, rgb) &&
        !pro_picture_put(picture, tile->generation, tile->level, tile->x, tile->y, rgb))
        abort();
    free(rgb);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct pro_picture *picture = NULL;
    Fovea__Message *message, *film = NULL;
    struct pro_reader reader;
    char error[PRO_ERROR_SIZE] = "";
    bool good = true;
    if (size > PRO_CHUNK) return 0;
    pro_reader_init(&reader, PRO_MAX_TO_CLIENT);
    if (!pro_reader_add(&reader, data, size)) abort();
    while (good && pro_reader_take(&reader, &message, error) == PRO_MESSAGE) {
        if (message->body_case == FOVEA__MESSAGE__BODY_WELCOME && !film) {
            picture = pro_picture_create(message->welcome, error);
            if (!picture && (!*error || strpbrk(error, "\r\n"))) abort();
            good = picture;
            film = message;
            continue;
        }
        if (message->body_case == FOVEA__MESSAGE__BODY_TILE && picture)
            put(picture, film->welcome, message->tile);
        fovea__message__free_unpacked(message, NULL);
    }
    if (picture) look(picture, film->welcome);
    pro_picture_destroy(picture);
    if (film) fovea__message__free_unpacked(film, NULL);
    pro_reader_finish(&reader);
    return 0;
}

#ifndef LIBFUZZER

int main(void)
{
    return fuzz_run_corpus(CORPUS, 20000);
}

#endif
