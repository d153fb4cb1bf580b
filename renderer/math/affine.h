/* Affine maps in double precision, so that a place far from the origin keeps its digits until the last step.
 */
#ifndef FOVEAD_RENDERER_AFFINE_H
#define FOVEAD_RENDERER_AFFINE_H

#include <math.h>
#include <stdbool.h>

/* 3 rows, 4 columns, column by column; the last column is the translation. */
struct rnd_affine {
    double m[12];
};

static inline struct rnd_affine rnd_affine_identity(void)
{
    return (struct rnd_affine){{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}};
}

/* w is 1 for places and 0 for directions. */
static inline void rnd_affine_apply(const struct rnd_affine *a, const float p[3], double w, double out[3])
{
    const double *m = a->m;
    for (int r = 0; r < 3; r++)
        out[r] = m[r] * (double)p[0] + m[3 + r] * (double)p[1] + m[6 + r] * (double)p[2] + m[9 + r] * w;
}

/* First b, then a. */
static inline struct rnd_affine rnd_affine_multiply(const struct rnd_affine *a, const struct rnd_affine *b)
{
    struct rnd_affine out;
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 3; r++)
            out.m[3 * c + r] = a->m[r] * b->m[3 * c] + a->m[3 + r] * b->m[3 * c + 1] +
                               a->m[6 + r] * b->m[3 * c + 2] + (c == 3 ? a->m[9 + r] : 0.0);
    return out;
}

/* Translation, then rotation (x, y, z, w, of any length; 0: none) and scale. */
static inline struct rnd_affine rnd_affine_pose(const float translation[3], const float rotation[4],
                                                const float scale[3])
{
    const double x = (double)rotation[0], y = (double)rotation[1], z = (double)rotation[2],
                 w = (double)rotation[3], l = x * x + y * y + z * z + w * w, k = l > 0.0 ? 2.0 / l : 0.0;
    struct rnd_affine out = {{1 - k * (y * y + z * z), k * (x * y + z * w), k * (x * z - y * w),
                              k * (x * y - z * w), 1 - k * (x * x + z * z), k * (y * z + x * w),
                              k * (x * z + y * w), k * (y * z - x * w), 1 - k * (x * x + y * y)}};
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) out.m[3 * c + r] *= (double)scale[c];
    for (int r = 0; r < 3; r++) out.m[9 + r] = (double)translation[r];
    return out;
}

/* The factor by which volumes grow; negative if handedness is reversed. */
static inline double rnd_affine_determinant(const struct rnd_affine *a)
{
    const double *m = a->m;
    return m[0] * (m[4] * m[8] - m[7] * m[5]) - m[3] * (m[1] * m[8] - m[7] * m[2]) +
           m[6] * (m[1] * m[5] - m[4] * m[2]);
}

/* The map of normals that belongs to a: the inverse transpose of its first three columns, column by column.
 * Normals stay on their side of a surface. False if there is no inverse, or none that floats can hold. */
static inline bool rnd_affine_normals(const struct rnd_affine *a, float out[9])
{
    const double *m = a->m, determinant = rnd_affine_determinant(a);
    bool finite = isfinite(determinant) && determinant != 0.0;
    for (int c = 0; c < 3; c++)
        for (int r = 0; r < 3; r++) {
            const int c1 = (c + 1) % 3, c2 = (c + 2) % 3, r1 = (r + 1) % 3, r2 = (r + 2) % 3;
            const double cofactor = m[3 * c1 + r1] * m[3 * c2 + r2] - m[3 * c2 + r1] * m[3 * c1 + r2];
            out[3 * c + r] = (float)(cofactor / determinant);
            finite = finite && isfinite(out[3 * c + r]);
        }
    return finite;
}

#endif
