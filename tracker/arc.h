/* arc: arcs on the sphere of directions, in degrees. Only for the files of tracker/. */
#ifndef FOVEAD_TRACKER_ARC_H
#define FOVEAD_TRACKER_ARC_H

#include <cglm/cglm.h>
#include <math.h>

/* The arc from one unit vector to another, as a vector in the tangent plane of the first: it points along the
 * start of the arc, and its length is that of the arc in degrees. Between opposite vectors it is any one of
 * the arcs. */
static inline void trk_arc(const float from[3], const float to[3], vec3 out_deg)
{
    vec3 a = {from[0], from[1], from[2]}, b = {to[0], to[1], to[2]}, tangent;
    float along = glm_vec3_dot(a, b);
    glm_vec3_scale(a, along, tangent);
    glm_vec3_sub(b, tangent, tangent);
    float across = glm_vec3_norm(tangent);
    float angle_deg = glm_deg(atan2f(across, along));
    if (across < 1e-7f && along < 0) glm_vec3_ortho(a, tangent);
    glm_vec3_scale_as(tangent, across < 1e-7f && along > 0 ? 0 : angle_deg, out_deg);
}

/* The end of an arc that starts at a unit vector. */
static inline void trk_along(const float from[3], const float arc_deg[3], float out[3])
{
    vec3 a = {from[0], from[1], from[2]}, arc = {arc_deg[0], arc_deg[1], arc_deg[2]}, end;
    float angle = glm_rad(glm_vec3_norm(arc));
    glm_vec3_normalize(arc);
    glm_vec3_scale(a, cosf(angle), end);
    glm_vec3_muladds(arc, sinf(angle), end);
    glm_vec3_normalize(end);
    out[0] = end[0], out[1] = end[1], out[2] = end[2];
}

static inline float trk_angle_deg(const float a[3], const float b[3])
{
    vec3 u = {a[0], a[1], a[2]}, v = {b[0], b[1], b[2]}, cross;
    glm_vec3_cross(u, v, cross);
    return glm_deg(atan2f(glm_vec3_norm(cross), glm_vec3_dot(u, v)));
}

#endif
