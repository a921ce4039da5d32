// A few answers are kept. Each is written by one side at a time: by the worker while BUSY, by the
// main thread otherwise.
#include "app/window_ground.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "base/memory.h"
#include "base/pool.h"
#include "geo/ellipsoid.h"

#define DEG (M_PI / 180)

// Between two places terrain is taken to differ by less than STEEP times their distance plus ROUGH
// metres.
#define STEEP 2.0
#define ROUGH 50.0
// An answer this near is the place itself.
#define SAME_M 0.01
// With more room than this nobody asks for terrain.
#define ORBIT_M 200e3

enum { ANSWERS = 4 };

enum state { EMPTY, BUSY, DONE };

struct answer {
    struct window_ground *ground;
    _Atomic int state;
    double lat, lon, height;
};

struct window_ground {
    perigee_planet *planet;
    double radius;
    struct pool *worker;
    struct answer answers[ANSWERS];
    atomic_bool news;
};

static double look_up(const struct window_ground *g, double lat, double lon)
{
    double height;
    return perigee_planet_height(g->planet, lat / DEG, lon / DEG, &height) ? (double)NAN : height;
}

static void work(void *arg, int worker)
{
    (void)worker;
    struct answer *a = arg;
    a->height = look_up(a->ground, a->lat, a->lon);
    atomic_store(&a->state, isfinite(a->height) ? DONE : EMPTY);
    atomic_store(&a->ground->news, true);
    glfwPostEmptyEvent();
}

struct window_ground *window_ground_create(perigee_planet *planet)
{
    struct window_ground *g = NEW(struct window_ground);
    perigee_planet_info info;
    perigee_planet_get_info(planet, &info);
    g->planet = planet;
    g->radius = info.equatorial_radius_m;
    g->worker = pool_create(1, ANSWERS);
    for (int i = 0; i < ANSWERS; i++) g->answers[i].ground = g;
    return g;
}

void window_ground_destroy(struct window_ground **ground)
{
    struct window_ground *g = *ground;
    if (!g) return;
    pool_destroy(&g->worker);
    free(g);
    *ground = NULL;
}

static double distance(const struct window_ground *g, const struct answer *a, double lat,
                       double lon)
{
    double along = sin(0.5 * (lat - a->lat)), across = sin(0.5 * (lon - a->lon));
    double h = along * along + cos(lat) * cos(a->lat) * across * across;
    return 2 * g->radius * asin(sqrt(fmin(h, 1)));
}

// The answer nearest to the place, at most one of them busy; and the one to overwrite: an empty or
// the farthest one.
static struct answer *nearest(struct window_ground *g, double lat, double lon, double *away,
                              struct answer **spare, int *busy)
{
    struct answer *best = NULL;
    double far = -1;
    *away = INFINITY;
    *spare = NULL;
    *busy = 0;
    for (int i = 0; i < ANSWERS; i++) {
        struct answer *a = &g->answers[i];
        int state = atomic_load(&a->state);
        double d = state == DONE ? distance(g, a, lat, lon) : INFINITY;
        *busy += state == BUSY;
        if (state != BUSY && d > far) {
            far = d;
            *spare = a;
        }
        if (d < *away) {
            *away = d;
            best = a;
        }
    }
    return best;
}

static void ask(struct window_ground *g, struct answer *a, double lat, double lon)
{
    a->lat = lat;
    a->lon = lon;
    atomic_store(&a->state, BUSY);
    if (!pool_try_submit(g->worker, work, a)) atomic_store(&a->state, EMPTY);
}

static void keep(struct answer *a, double lat, double lon, double height)
{
    a->lat = lat;
    a->lon = lon;
    a->height = height;
    atomic_store(&a->state, DONE);
}

double window_ground_at(struct window_ground *g, double lat, double lon, double room)
{
    if (isfinite(room) && room > ORBIT_M) return 0;
    struct answer *spare;
    double away, height = NAN;
    int busy;
    const struct answer *best = nearest(g, lat, lon, &away, &spare, &busy);
    double known = best ? best->height : (double)NAN;
    if (away < SAME_M) return known;
    bool near = isfinite(room) && STEEP * away + ROUGH >= room;
    if (near && perigee_planet_height_now(g->planet, lat / DEG, lon / DEG, &height)) {
        if (spare) keep(spare, lat, lon, height);
        return height;
    }
    // What lies ahead never keeps the place itself waiting.
    if (spare && busy < (isinf(room) ? 1 : 2)) ask(g, spare, lat, lon);
    if (!near || isnan(height)) return known;
    return height;
}

bool window_ground_take_news(struct window_ground *g)
{
    return atomic_exchange(&g->news, false);
}
