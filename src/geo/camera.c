// Forward, right and up without roll are built in east, north, up; roll turns right and up about
// forward.
#include "geo/camera.h"

// Below this sine the camera looks straight up or down, and heading and roll are one turn.
#define VERTICAL 1e-9

static double wrap_turn(double angle)
{
    double w = angle - 2 * M_PI * floor(angle / (2 * M_PI));
    return w < 2 * M_PI ? w : 0;
}

dmat3 geo_eye_from_ecef(const geo_camera *c)
{
    double ch = cos(c->heading), sh = sin(c->heading);
    double cp = cos(c->pitch), sp = sin(c->pitch);
    double cr = cos(c->roll), sr = sin(c->roll);
    dvec3 forward = {sh * cp, ch * cp, sp};
    dvec3 level_right = {ch, -sh, 0};
    dvec3 level_up = {-sh * sp, -ch * sp, cp};
    dvec3 right = dvec3_mad(dvec3_scale(level_right, cr), level_up, -sr);
    dvec3 up = dvec3_mad(dvec3_scale(level_up, cr), level_right, sr);
    dmat3 ecef = geo_ecef_from_enu(c->position.lat, c->position.lon);
    return (dmat3){
        {dmat3_mul(ecef, right), dmat3_mul(ecef, up), dmat3_mul(ecef, dvec3_scale(forward, -1))}};
}

dmat3 geo_eye_over(geo_ellipsoid e, const geo_camera *c)
{
    geo_camera there = *c;
    if (geo_is_plane(e)) there.position.lat = there.position.lon = 0;
    return geo_eye_from_ecef(&there);
}

void geo_camera_orient(geo_camera *c, dmat3 eye_from_ecef)
{
    dmat3 enu = dmat3_transpose(geo_ecef_from_enu(c->position.lat, c->position.lon));
    dvec3 right = dmat3_mul(enu, eye_from_ecef.row[0]);
    dvec3 forward = dvec3_scale(dmat3_mul(enu, eye_from_ecef.row[2]), -1);
    double level = hypot(forward.x, forward.y);
    c->pitch = atan2(forward.z, level);
    if (level < VERTICAL) {
        c->heading = wrap_turn(atan2(-right.y, right.x));
        c->roll = 0;
        return;
    }
    dvec3 level_right = {forward.y / level, -forward.x / level, 0};
    dvec3 level_up = dvec3_cross(level_right, forward);
    c->heading = wrap_turn(atan2(forward.x, forward.y));
    c->roll = atan2(-dvec3_dot(right, level_up), dvec3_dot(right, level_right));
}
