// A frame is drawn only when there is something new to see; between frames the thread sleeps in the
// event queue.
#include "app/window.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
#include <unistd.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "app/camera_string.h"
#include "app/control.h"
#include "app/image_png.h"
#include "app/input.h"
#include "app/ui.h"
#include "app/window_clock.h"
#include "app/window_ground.h"
#include "app/window_views.h"
#include "base/log.h"

#define DEG (M_PI / 180)

#define MESSAGE_S 4.0
// Data missing for less than this is not worth a word.
#define LATE_S 0.5
// The longest sleep, and the pause between looks at a motion that shows nothing new.
#define IDLE_S  0.5
#define PAUSE_S 0.008
// The sun is moved when it stands this much beside where it was drawn: two seconds are half a
// minute of arc.
#define SUN_STEP_S 2.0

enum { SCREENSHOTS = 9999 };

struct window {
    const struct window_params *params;
    perigee_planet_info info;
    GLFWwindow *glfw;
    struct window_views *views;
    struct window_ground *ground;
    struct control *control;
    struct input *input;
    struct window_clock clock;
    bool ui, help, quit, failed;
    double now_s, drawn_time_s;
    double frame_ms;
    int frames, screenshots;
    char message[512];
    double message_until_s;
    char missing[512];
    int missing_count;
    double complete_s; // when nothing was missing last
};

bool window_display_available(void)
{
    const char *x = getenv("DISPLAY"), *wayland = getenv("WAYLAND_DISPLAY");
    if (!(x && *x) && !(wayland && *wayland)) return false;
    if (!glfwInit()) return false;
    glfwTerminate();
    return true;
}

static perigee_camera camera_in_degrees(const geo_camera *c)
{
    return (perigee_camera){.lat_deg = c->position.lat / DEG,
                            .lon_deg = c->position.lon / DEG,
                            .alt_m = c->position.height,
                            .heading_deg = c->heading / DEG,
                            .pitch_deg = c->pitch / DEG,
                            .roll_deg = c->roll / DEG,
                            .fov_deg = c->fov_y / DEG};
}

static geo_camera camera_in_radians(const perigee_camera *c)
{
    double fov_deg = c->fov_deg > 0 ? c->fov_deg : 60;
    return (geo_camera){{c->lat_deg * DEG, c->lon_deg * DEG, c->alt_m},
                        c->heading_deg * DEG,
                        c->pitch_deg * DEG,
                        c->roll_deg * DEG,
                        fov_deg * DEG};
}

static double ground(void *user, double lat, double lon, double room)
{
    struct window *w = user;
    return window_ground_at(w->ground, lat, lon, room);
}

static bool pick(void *user, double x_px, double y_px, geodetic *point)
{
    struct window *w = user;
    double lat_deg, lon_deg, height;
    if (!window_views_pick(w->views, x_px, y_px, &lat_deg, &lon_deg, &height)) return false;
    *point = (geodetic){lat_deg * DEG, lon_deg * DEG, height};
    return true;
}

__attribute__((format(printf, 2, 3))) static void announce(struct window *w, const char *format,
                                                           ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(w->message, sizeof w->message, format, args);
    va_end(args);
    w->message_until_s = glfwGetTime() + MESSAGE_S;
}

static const char *attribution(const struct window *w)
{
    return w->params->attribution ? w->params->attribution : w->info.attribution;
}

// The first free number in the folder; false when there is none.
static bool screenshot_path(struct window *w, char *path, size_t size)
{
    const char *dir = w->params->screenshot_dir ? w->params->screenshot_dir : ".";
    while (++w->screenshots <= SCREENSHOTS) {
        int length = snprintf(path, size, "%s/perigee-%04d.png", dir, w->screenshots);
        if (length < 0 || (size_t)length >= size) return false;
        if (access(path, F_OK)) return true;
    }
    return false;
}

static void take_screenshot(struct window *w)
{
    int width, height;
    char path[4096], camera[CAMERA_STRING_SIZE];
    glfwGetFramebufferSize(w->glfw, &width, &height);
    uint8_t *rgb = width > 0 && height > 0 ? calloc((size_t)width * (size_t)height, 3) : NULL;
    if (!rgb || !screenshot_path(w, path, sizeof path)) {
        announce(w, "No room for a screenshot");
        free(rgb);
        return;
    }
    perigee_camera c = camera_in_degrees(control_camera(w->control));
    camera_string_format(&c, camera, sizeof camera);
    struct image_text texts[] = {
        {"Software", "Perigee"}, {"Camera", camera}, {"Source", attribution(w)}};
    int text_count = attribution(w)[0] ? 3 : 2;
    status s = window_views_picture(w->views, &c, w->clock.unix_time_s, width, height, rgb);
    if (!s) s = image_png_write(path, width, height, rgb, texts, text_count);
    if (s) announce(w, "No screenshot: %s", perigee_last_error());
    else announce(w, "Saved %s", path);
    free(rgb);
}

static void copy_camera(struct window *w)
{
    char text[CAMERA_STRING_SIZE];
    perigee_camera c = camera_in_degrees(control_camera(w->control));
    camera_string_format(&c, text, sizeof text);
    glfwSetClipboardString(w->glfw, text);
    announce(w, "Copied %s", text);
}

// The modes in the window's title.
static void show_modes(struct window *w)
{
    char title[256];
    const char *right = window_views_mode(w->views, 1);
    snprintf(title, sizeof title, "%s: %s%s%s", w->params->title ? w->params->title : "Perigee",
             window_views_mode(w->views, 0), right ? " | " : "", right ? right : "");
    glfwSetWindowTitle(w->glfw, title);
}

static void next_mode(struct window *w)
{
    bool split = window_views_is_split(w->views);
    status s = window_views_next_mode(w->views);
    if (s) announce(w, "The mode stays: %s", perigee_last_error());
    else announce(w, "%s%s", split ? "Right: " : "", window_views_mode(w->views, split));
    show_modes(w);
}

static void toggle_split(struct window *w)
{
    int width, height;
    glfwGetFramebufferSize(w->glfw, &width, &height);
    status s = window_views_toggle_split(w->views, width, height);
    double bytes = 0;
    for (int i = 0; i < 2; i++) bytes += (double)window_views_stats(w->views, i).gpu_bytes;
    if (s) announce(w, "No split: %s", perigee_last_error());
    else
        announce(w, "%s, %.0f MiB of GPU memory",
                 window_views_is_split(w->views) ? "Split: two views" : "One view", bytes / 0x1p20);
    show_modes(w);
}

static void handle(void *user, enum input_command command)
{
    struct window *w = user;
    double now = (double)time(NULL);
    double lon_deg = control_camera(w->control)->position.lon / DEG;
    switch (command) {
    case INPUT_HELP:
        w->help = !w->help;
        break;
    case INPUT_SCREENSHOT:
        take_screenshot(w);
        break;
    case INPUT_COPY_CAMERA:
        copy_camera(w);
        break;
    case INPUT_TOGGLE_TIME:
        window_clock_toggle(&w->clock, now, lon_deg);
        break;
    case INPUT_TIME_SLOWER:
        window_clock_change_speed(&w->clock, -1, now, lon_deg);
        break;
    case INPUT_TIME_FASTER:
        window_clock_change_speed(&w->clock, 1, now, lon_deg);
        break;
    case INPUT_NEXT_MODE:
        next_mode(w);
        break;
    case INPUT_SPLIT:
        toggle_split(w);
        break;
    case INPUT_NEXT_DIFFERENCE:
        window_views_next_difference(w->views);
        break;
    case INPUT_LEAVE:
        if (w->help) w->help = false;
        else w->quit = true;
        break;
    }
}

static bool fail(const char *what)
{
    const char *why = NULL;
    glfwGetError(&why);
    log_error("window: %s%s%s", what, why ? ": " : "", why ? why : "");
    return false;
}

static bool open_window(struct window *w)
{
    const struct window_params *p = w->params;
    if (!glfwInit()) return fail("no display (perigee render and perigee fly need none)");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    w->glfw = glfwCreateWindow(p->width > 0 ? p->width : 1280, p->height > 0 ? p->height : 800,
                               p->title ? p->title : "Perigee", NULL, NULL);
    if (!w->glfw) return fail("no OpenGL 4.5 core context");
    glfwMakeContextCurrent(w->glfw);
    glfwSwapInterval(p->vsync ? 1 : 0);
    return true;
}

static bool open_scene(struct window *w)
{
    const struct window_params *p = w->params;
    perigee_planet_get_info(p->planet, &w->info);
    if (window_views_create(p->planet, p->view, &w->views)) return false;
    show_modes(w);
    int width, height;
    glfwGetFramebufferSize(w->glfw, &width, &height);
    w->ground = window_ground_create(p->planet);
    const perigee_planet_info *i = &w->info;
    struct control_world world = {{.a = i->equatorial_radius_m,
                                   .b = i->polar_radius_m,
                                   .south = DEG * i->map_south_deg,
                                   .north = DEG * i->map_north_deg,
                                   .west = DEG * i->map_west_deg,
                                   .east = DEG * i->map_east_deg},
                                  w,
                                  ground,
                                  pick};
    geo_camera start = camera_in_radians(&p->start);
    w->control = control_create(&world, &start, width, height);
    w->input = input_create(w->glfw, w->control, handle, w);
    float scale_x = 1, scale_y = 1;
    glfwGetWindowContentScale(w->glfw, &scale_x, &scale_y);
    w->ui = ui_init(w->glfw, fmaxf(scale_x, 1));
    return w->ui || fail("the overlay cannot start");
}

static void draw_overlay(struct window *w)
{
    char time_text[80];
    window_clock_text(&w->clock, time_text, sizeof time_text);
    const geo_camera *c = control_camera(w->control);
    if (w->missing_count == 0) w->complete_s = w->now_s;
    bool late = w->now_s - w->complete_s > LATE_S;
    perigee_camera shown = camera_in_degrees(c);
    perigee_planet_geographic(w->params->planet, 1, &shown.lat_deg, &shown.lon_deg);
    struct ui_state state = {
        .camera = shown,
        .ground_m = control_ground(w->control),
        .frame_ms = w->frame_ms,
        .modes = {window_views_mode(w->views, 0), window_views_mode(w->views, 1)},
        .stats = {window_views_stats(w->views, 0), window_views_stats(w->views, 1)},
        .difference = window_views_difference(w->views),
        .gain = WINDOW_VIEWS_GAIN,
        .missing = w->missing,
        .missing_count = late ? w->missing_count : 0,
        .time = time_text,
        .attribution = attribution(w),
        .message = w->now_s < w->message_until_s ? w->message : "",
        .flying = control_is_flying(w->control),
        .help = &w->help};
    ui_draw(&state);
}

static status draw_frame(struct window *w)
{
    int width, height;
    glfwGetFramebufferSize(w->glfw, &width, &height);
    if (width < 1 || height < 1) return 0;
    double begin = glfwGetTime();
    perigee_camera camera = camera_in_degrees(control_camera(w->control));
    status s = window_views_render(w->views, &camera, w->clock.unix_time_s, width, height, 0);
    w->drawn_time_s = w->clock.unix_time_s;
    if (s) return s;
    w->missing_count = window_views_missing(w->views, w->missing, sizeof w->missing);
    draw_overlay(w);
    glfwSwapBuffers(w->glfw);
    w->frame_ms = (glfwGetTime() - begin) * 1e3;
    w->frames++;
    return 0;
}

// Advances everything that moves by itself. True when the picture is no longer true.
static bool advance(struct window *w)
{
    double now = glfwGetTime(), dt = now - w->now_s;
    bool told =
        w->message_until_s > 0 && w->now_s < w->message_until_s && now >= w->message_until_s;
    w->now_s = now;
    window_clock_step(&w->clock, dt);
    bool moved = control_step(w->control, dt);
    bool sun = fabs(w->clock.unix_time_s - w->drawn_time_s) > SUN_STEP_S ||
               isnan(w->clock.unix_time_s) != isnan(w->drawn_time_s);
    bool active = input_take_activity(w->input);
    bool news = window_ground_take_news(w->ground);
    return moved || told || sun || active || news || window_views_need_redraw(w->views) ||
           w->params->frames > 0;
}

static void wait_for_events(const struct window *w, bool drew)
{
    double rate = fabs(window_clock_rate(&w->clock));
    double sleep = rate > 0 ? fmin(IDLE_S, SUN_STEP_S / rate) : IDLE_S;
    if (control_is_moving(w->control)) sleep = PAUSE_S;
    if (drew) glfwPollEvents();
    else glfwWaitEventsTimeout(fmax(sleep, PAUSE_S));
}

static bool is_over(const struct window *w)
{
    return w->quit || w->failed || glfwWindowShouldClose(w->glfw) ||
           (w->params->run_s > 0 && glfwGetTime() > w->params->run_s) ||
           (w->params->frames > 0 && w->frames >= w->params->frames);
}

static void run(struct window *w)
{
    glfwSetTime(0);
    w->drawn_time_s = w->clock.unix_time_s;
    while (!is_over(w)) {
        bool draw = advance(w);
        if (draw) w->failed = draw_frame(w) != 0;
        wait_for_events(w, draw);
    }
}

static void close_window(struct window *w)
{
    if (w->ui) ui_deinit();
    input_destroy(&w->input);
    control_destroy(&w->control);
    perigee_planet_stop_waiting(w->params->planet);
    window_ground_destroy(&w->ground);
    window_views_destroy(&w->views);
    if (w->glfw) glfwDestroyWindow(w->glfw);
    glfwTerminate();
}

int window_run(const struct window_params *params)
{
    struct window w = {.params = params, .clock = window_clock_make(params->unix_time_s)};
    bool opened = open_window(&w) && open_scene(&w);
    if (opened) run(&w);
    close_window(&w);
    return opened && !w.failed ? 0 : 1;
}
