// The camera is always (latitude, longitude, altitude, heading, pitch, roll): a gesture finds a
// rotation about the planet's centre, applies it to the position, and carries the heading along as
// a tangent vector, never by taking the orientation apart, which has no answer when looking
// straight down. Rotations do not preserve the altitude over an ellipsoid, so the solvers restore
// it and repeat; each round gains the factor 1 / flattening.
#include "app/control_pose.h"

// Beyond this latitude a drag turns the globe as a ball; below, it keeps the heading.
#define FREE_LAT       (80.0 * M_PI / 180.0)
#define FREE_LAT_PRESS (75.0 * M_PI / 180.0)
// A drag towards the horizon carries the camera no farther than this many times the distance of the
// grabbed point.
#define REACH     30.0
#define PITCH_MAX (85.0 * M_PI / 180.0)
// Orbiting stops here above the pivot's own horizon.
#define ORBIT_HORIZON (89.0 * M_PI / 180.0)

bool pose_is_finite(const geo_camera *c)
{
    return isfinite(c->position.lat) && isfinite(c->position.lon) && isfinite(c->position.height) &&
           isfinite(c->heading) && isfinite(c->pitch) && isfinite(c->roll) && isfinite(c->fov_y);
}

static dmat3 rotation(dvec3 axis, double angle)
{
    double s = sin(angle), c = cos(angle), k = 2.0 * sin(angle / 2) * sin(angle / 2);
    dvec3 a = axis;
    return (dmat3){{{c + k * a.x * a.x, k * a.x * a.y - s * a.z, k * a.x * a.z + s * a.y},
                    {k * a.y * a.x + s * a.z, c + k * a.y * a.y, k * a.y * a.z - s * a.x},
                    {k * a.z * a.x - s * a.y, k * a.z * a.y + s * a.x, c + k * a.z * a.z}}};
}

static dmat3 compose(dmat3 a, dmat3 b)
{
    dmat3 columns = dmat3_transpose(b), out;
    for (int i = 0; i < 3; i++) out.row[i] = dmat3_mul(a, columns.row[i]);
    return dmat3_transpose(out);
}

static double angle_between(dvec3 a, dvec3 b)
{
    return atan2(dvec3_length(dvec3_cross(a, b)), dvec3_dot(a, b));
}

// The smallest rotation that takes direction a to direction b.
static dmat3 rotation_between(dvec3 a, dvec3 b)
{
    dvec3 axis = dvec3_cross(a, b);
    double length = dvec3_length(axis);
    if (!(length > 0)) return rotation((dvec3){0, 0, 1}, 0);
    return rotation(dvec3_scale(axis, 1 / length), atan2(length, dvec3_dot(a, b)));
}

static dvec3 enu_column(geo_ellipsoid e, double lat, double lon, int column)
{
    return dmat3_transpose(geo_frame_at(e, lat, lon)).row[column];
}

static dvec3 camera_ecef(geo_ellipsoid e, const geo_camera *c)
{
    return geo_ecef_from_geodetic(e, c->position);
}

// Horizontal unit vector towards an azimuth.
static dvec3 tangent(geo_ellipsoid e, const geo_camera *c, double azimuth)
{
    dmat3 ecef_from_enu = geo_frame_at(e, c->position.lat, c->position.lon);
    return dmat3_mul(ecef_from_enu, (dvec3){sin(azimuth), cos(azimuth), 0});
}

static double azimuth_of(geo_ellipsoid e, geodetic at, dvec3 v)
{
    return atan2(dvec3_dot(v, enu_column(e, at.lat, at.lon, 0)),
                 dvec3_dot(v, enu_column(e, at.lat, at.lon, 1)));
}

// Puts the camera at an ECEF position with a forward tangent carried there; pitch and roll stay.
static void place(geo_ellipsoid e, geo_camera *c, dvec3 position, double height, dvec3 forward,
                  bool keep_heading)
{
    geo_camera next = *c;
    next.position = geo_geodetic_from_ecef(e, position);
    if (!isnan(height)) next.position.height = height;
    if (!keep_heading) next.heading = azimuth_of(e, next.position, forward);
    if (pose_is_finite(&next)) *c = next;
}

// Over a plane the camera is carried along, its orientation as it is.
static void carry(geo_ellipsoid e, geo_camera *c, dvec3 position)
{
    place(e, c, position, NAN, (dvec3){0}, true);
}

// Where a ray meets the level ground at a height; when it does not, or farther than `reach`, the
// place over which it is so far.
static dvec3 ray_on_plane(dvec3 p, dvec3 dir, double height, double reach)
{
    double t = (height - p.x) / dir.x;
    if (!(t >= 0 && t <= reach)) t = reach;
    dvec3 at = dvec3_mad(p, dir, t);
    return (dvec3){height, at.y, at.z};
}

// The heading is held between the polar caps; inside them it is carried along the great circle.
static bool holds_heading(geo_ellipsoid e, const geo_camera *c, dvec3 next)
{
    return fabs(c->position.lat) < FREE_LAT && fabs(geo_geodetic_from_ecef(e, next).lat) < FREE_LAT;
}

static void rotate(geo_ellipsoid e, geo_camera *c, dmat3 r, bool keep_heading)
{
    dvec3 forward = dmat3_mul(r, tangent(e, c, c->heading));
    place(e, c, dmat3_mul(r, camera_ecef(e, c)), c->position.height, forward, keep_heading);
}

dvec3 pose_eye_ray(const geo_camera *c, struct pose_screen s, double x_px, double y_px)
{
    double k = 2 * tan(c->fov_y / 2) / s.height;
    return dvec3_normalize((dvec3){(x_px - 0.5 * s.width) * k, (0.5 * s.height - y_px) * k, -1});
}

static dvec3 ecef_from_eye(geo_ellipsoid e, const geo_camera *c, dvec3 eye)
{
    return dmat3_mul(dmat3_transpose(geo_eye_over(e, c)), eye);
}

dvec3 pose_ray(geo_ellipsoid e, const geo_camera *c, struct pose_screen s, double x_px, double y_px)
{
    return ecef_from_eye(e, c, pose_eye_ray(c, s, x_px, y_px));
}

bool pose_project(geo_ellipsoid e, const geo_camera *c, struct pose_screen s, dvec3 point,
                  double *x_px, double *y_px)
{
    dvec3 v = dmat3_mul(geo_eye_over(e, c), dvec3_sub(point, camera_ecef(e, c)));
    if (!(v.z < 0)) return false;
    double k = s.height / (2 * tan(c->fov_y / 2));
    *x_px = 0.5 * s.width - k * v.x / v.z;
    *y_px = 0.5 * s.height + k * v.y / v.z;
    return true;
}

// Where a ray from p meets the sphere, the closest approach when it misses; at most `reach` away,
// then put radially back onto the sphere.
static dvec3 ray_on_sphere(dvec3 p, dvec3 dir, double radius, bool far, double reach)
{
    double along = -dvec3_dot(p, dir);
    dvec3 nearest = dvec3_mad(p, dir, along);
    double below = (radius - dvec3_length(nearest)) * (radius + dvec3_length(nearest));
    bool inside = dvec3_length(p) < radius;
    double half = below > 0 ? sqrt(below) : 0;
    double t = inside || far ? along + half : along - half;
    t = clamp_double(t, 0, reach);
    dvec3 hit = dvec3_mad(p, dir, t);
    return dvec3_scale(hit, radius / dvec3_length(hit));
}

struct pose_grab pose_grab_make(geo_ellipsoid e, const geo_camera *c, dvec3 point)
{
    dvec3 p = camera_ecef(e, c), to = dvec3_sub(point, p);
    double lat = geo_geodetic_from_ecef(e, point).lat;
    struct pose_grab grab = {.point = point, .distance = dvec3_length(to)};
    grab.free = fabs(c->position.lat) > FREE_LAT_PRESS || fabs(lat) > FREE_LAT_PRESS;
    grab.far = dvec3_dot(point, to) > 0;
    return grab;
}

struct pose_grab pose_grab_sphere(geo_ellipsoid e, const geo_camera *c, dvec3 eye_ray,
                                  double radius)
{
    dvec3 dir = ecef_from_eye(e, c, eye_ray);
    if (geo_is_plane(e)) {
        double reach = REACH * fabs(c->position.height);
        return pose_grab_make(e, c, ray_on_plane(camera_ecef(e, c), dir, 0, reach));
    }
    dvec3 point = ray_on_sphere(camera_ecef(e, c), dir, radius, false, INFINITY);
    struct pose_grab grab = pose_grab_make(e, c, point);
    grab.far = false;
    return grab;
}

// The rotation along the camera's meridian and then about the axis that takes q to g: it keeps the
// heading. False where there is none, or only by a wild turn about a pole.
static bool heading_rotation(double lon, dvec3 q, dvec3 g, dmat3 *r)
{
    dvec3 east = {-sin(lon), cos(lon), 0};
    double across = dvec3_cross(east, q).z;
    double m = hypot(q.z, across);
    if (!(fabs(g.z) <= m)) return false;
    double middle = atan2(across, q.z), open = acos(g.z / m);
    double b1 = remainder(middle + open, 2 * M_PI), b2 = remainder(middle - open, 2 * M_PI);
    dmat3 along = rotation(east, fabs(b1) < fabs(b2) ? b1 : b2);
    dvec3 q1 = dmat3_mul(along, q);
    double about = remainder(atan2(g.y, g.x) - atan2(q1.y, q1.x), 2 * M_PI);
    if (fabs(about) > 0.5 && fabs(about) > 4 * angle_between(q, g)) return false;
    *r = compose(rotation((dvec3){0, 0, 1}, about), along);
    return true;
}

static void drag_step(geo_ellipsoid e, geo_camera *c, struct pose_grab *grab, dvec3 q)
{
    dmat3 r;
    if (!grab->free) {
        bool held = heading_rotation(c->position.lon, q, grab->point, &r) &&
                    holds_heading(e, c, dmat3_mul(r, camera_ecef(e, c)));
        grab->free = !held;
    }
    if (grab->free) r = rotation_between(q, grab->point);
    rotate(e, c, r, !grab->free);
}

void pose_drag(geo_ellipsoid e, geo_camera *c, struct pose_grab *grab, dvec3 eye_ray)
{
    if (geo_is_plane(e)) {
        dvec3 p = camera_ecef(e, c), dir = ecef_from_eye(e, c, eye_ray);
        dvec3 q = ray_on_plane(p, dir, grab->point.x, REACH * grab->distance);
        carry(e, c, dvec3_add(p, dvec3_sub(grab->point, q)));
        return;
    }
    double radius = dvec3_length(grab->point), last = INFINITY;
    geo_camera best = *c;
    for (int i = 0; i < 12; i++) {
        dvec3 q = ray_on_sphere(camera_ecef(e, c), ecef_from_eye(e, c, eye_ray), radius, grab->far,
                                REACH * grab->distance);
        double off = angle_between(q, grab->point);
        if (!(off < last)) break;
        best = *c;
        if (off < 1e-15) break;
        last = off;
        drag_step(e, c, grab, q);
    }
    *c = best;
}

void pose_zoom(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray, double factor)
{
    dvec3 p = camera_ecef(e, c);
    dvec3 next = dvec3_mad(point, dvec3_sub(p, point), factor);
    if (geo_is_plane(e)) {
        carry(e, c, next); // the point stays on its ray by itself
        return;
    }
    dvec3 forward = dmat3_mul(rotation_between(p, next), tangent(e, c, c->heading));
    place(e, c, next, NAN, forward, holds_heading(e, c, next));
    geo_camera straight = *c;
    struct pose_grab grab = pose_grab_make(e, c, point);
    pose_drag(e, c, &grab, eye_ray);
    // Level views can make the correction larger than the step it corrects: then the straight way
    // is the better answer.
    double moved = dvec3_length(dvec3_sub(camera_ecef(e, c), next));
    if (!(moved < 0.5 * grab.distance)) *c = straight;
}

void pose_aim(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray)
{
    dvec3 v = dvec3_normalize(dvec3_sub(point, camera_ecef(e, c)));
    double up = dvec3_dot(v, geo_up_at(e, c->position.lat, c->position.lon));
    // The eye ray without the camera's roll: right, up, ahead.
    double cr = cos(c->roll), sr = sin(c->roll);
    double right = eye_ray.x * cr + eye_ray.y * sr, above = eye_ray.y * cr - eye_ray.x * sr;
    double ahead = -eye_ray.z;
    double lift = atan2(above, ahead);
    double sine = asin(clamp_double(up / hypot(above, ahead), -1, 1));
    double p1 = sine - lift, p2 = remainder(M_PI - sine - lift, 2 * M_PI);
    double pitch = fabs(p1 - c->pitch) < fabs(p2 - c->pitch) ? p1 : p2;
    geo_camera next = *c;
    next.pitch = clamp_double(pitch, -M_PI / 2, M_PI / 2);
    double level = ahead * cos(next.pitch) - above * sin(next.pitch);
    // Straight above or below the point any heading will do: the camera keeps its own.
    if (hypot(level, right) > 1e-9 && sqrt(1 - fmin(up * up, 1)) > 1e-9)
        next.heading = remainder(azimuth_of(e, c->position, v) - atan2(right, level), 2 * M_PI);
    if (pose_is_finite(&next)) *c = next;
}

// The tilt that the pitch and the pivot's horizon leave of the one asked for.
static double orbit_tilt(const geo_camera *c, dvec3 from_point, dvec3 normal, dvec3 ahead,
                         double tilt)
{
    double free_tilt =
        clamp_double(c->pitch + tilt, -M_PI / 2, fmax(PITCH_MAX, c->pitch)) - c->pitch;
    double lean = atan2(-dvec3_dot(from_point, ahead), dvec3_dot(from_point, normal));
    double room = fmax(ORBIT_HORIZON - lean, 0);
    return fmin(free_tilt, room);
}

void pose_orbit(geo_ellipsoid e, geo_camera *c, dvec3 point, dvec3 eye_ray, double turn,
                double tilt)
{
    dvec3 p = camera_ecef(e, c), from = dvec3_sub(p, point);
    geodetic at = geo_geodetic_from_ecef(e, point);
    dvec3 normal = geo_up_at(e, at.lat, at.lon);
    dvec3 right = tangent(e, c, c->heading + M_PI / 2);
    right = dvec3_normalize(dvec3_mad(right, normal, -dvec3_dot(right, normal)));
    dvec3 ahead = dvec3_cross(normal, right);
    double lean = orbit_tilt(c, from, normal, ahead, tilt);
    dmat3 r = compose(rotation(normal, -turn), rotation(right, lean));
    dvec3 forward = dmat3_mul(r, tangent(e, c, c->heading));
    geo_camera next = *c;
    place(e, &next, dvec3_add(point, dmat3_mul(r, from)), NAN, forward, false);
    next.pitch = clamp_double(next.pitch + lean, -M_PI / 2, M_PI / 2);
    pose_aim(e, &next, point, eye_ray);
    if (pose_is_finite(&next)) *c = next;
}

void pose_look(geo_camera *c, double turn, double tilt)
{
    geo_camera next = *c;
    next.heading = remainder(c->heading + turn, 2 * M_PI);
    next.pitch = clamp_double(c->pitch + tilt, -M_PI / 2, M_PI / 2);
    if (pose_is_finite(&next)) *c = next;
}

void pose_move(geo_ellipsoid e, geo_camera *c, double right, double ahead)
{
    double distance = hypot(right, ahead);
    if (!(distance > 0)) return;
    dvec3 p = camera_ecef(e, c);
    dvec3 to = tangent(e, c, c->heading + atan2(right, ahead));
    if (geo_is_plane(e)) {
        carry(e, c, dvec3_mad(p, to, distance));
        return;
    }
    dvec3 axis = dvec3_normalize(dvec3_cross(p, to));
    dmat3 r = rotation(axis, distance / dvec3_length(p));
    rotate(e, c, r, holds_heading(e, c, dmat3_mul(r, p)));
}
