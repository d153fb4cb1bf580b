/* What the pixels of an image are used for. */
#ifndef FOVEAD_RENDERER_PIXELS_H
#define FOVEAD_RENDERER_PIXELS_H

/* What pixels are used for, which decides what their numbers mean. */
enum rnd_pixels_use {
    RND_PIXELS_DATA,   /* the numbers as they are stored: normals, roughness, coverage */
    RND_PIXELS_SRGB,   /* colours: integers are sRGB, whatever the file says (glTF 2.0, section 3.8.3) */
    RND_PIXELS_COLOUR, /* colours: integers are sRGB, unless the file names another transfer function */
};

#endif
