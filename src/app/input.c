#include "app/input.h"

#include <math.h>
#include <stddef.h>
#include <stdlib.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "app/control.h"
#include "app/ui.h"
#include "base/memory.h"

#define DOUBLE_CLICK_S  0.35
#define DOUBLE_CLICK_PX 6.0

struct input {
    struct control *control;
    input_handler handler;
    void *user;
    bool active;
    bool turning;     // the left button turns, pressed with Ctrl
    double pressed_s; // last press of the left button
    double pressed_x, pressed_y;
};

struct key_binding {
    int key;
    enum control_key control;
};

// By the key's place, so that WASD is a cross on every keyboard.
static const struct key_binding places[] = {
    {GLFW_KEY_LEFT, CONTROL_LEFT},
    {GLFW_KEY_RIGHT, CONTROL_RIGHT},
    {GLFW_KEY_UP, CONTROL_UP},
    {GLFW_KEY_DOWN, CONTROL_DOWN},
    {GLFW_KEY_KP_ADD, CONTROL_ZOOM_IN},
    {GLFW_KEY_KP_SUBTRACT, CONTROL_ZOOM_OUT},
    {GLFW_KEY_LEFT_SHIFT, CONTROL_SHIFT},
    {GLFW_KEY_RIGHT_SHIFT, CONTROL_SHIFT},
    {GLFW_KEY_W, CONTROL_FLY_AHEAD},
    {GLFW_KEY_S, CONTROL_FLY_BACK},
    {GLFW_KEY_A, CONTROL_FLY_LEFT},
    {GLFW_KEY_D, CONTROL_FLY_RIGHT},
    {GLFW_KEY_R, CONTROL_FLY_RISE},
    {GLFW_KEY_F, CONTROL_FLY_SINK},
    {GLFW_KEY_Q, CONTROL_ROLL_LEFT},
    {GLFW_KEY_E, CONTROL_ROLL_RIGHT},
};
enum { PLACES = sizeof places / sizeof places[0] };

static struct input *input_of(GLFWwindow *window)
{
    struct input *input = glfwGetWindowUserPointer(window);
    input->active = true;
    return input;
}

// The cursor in pixels of the framebuffer.
static void cursor_px(GLFWwindow *window, double *x, double *y)
{
    int width, height, width_px, height_px;
    glfwGetCursorPos(window, x, y);
    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &width_px, &height_px);
    if (width < 1 || height < 1) return;
    *x *= (double)width_px / width;
    *y *= (double)height_px / height;
}

static void press_left(struct input *in, double x, double y, bool ctrl)
{
    double now = glfwGetTime();
    bool twice = now - in->pressed_s < DOUBLE_CLICK_S &&
                 hypot(x - in->pressed_x, y - in->pressed_y) < DOUBLE_CLICK_PX;
    in->pressed_s = twice ? -1 : now;
    in->pressed_x = x;
    in->pressed_y = y;
    in->turning = ctrl;
    if (twice && !control_is_flying(in->control)) control_double_click(in->control, x, y);
    else control_press(in->control, ctrl ? CONTROL_ORBIT : CONTROL_DRAG, x, y);
}

static void on_button(GLFWwindow *window, int button, int action, int mods)
{
    struct input *in = input_of(window);
    double x, y;
    cursor_px(window, &x, &y);
    bool left = button == GLFW_MOUSE_BUTTON_LEFT;
    if (button > GLFW_MOUSE_BUTTON_MIDDLE) return;
    if (action == GLFW_RELEASE)
        control_release(in->control, left && !in->turning ? CONTROL_DRAG : CONTROL_ORBIT);
    else if (ui_wants_mouse()) return;
    else if (left) press_left(in, x, y, mods & GLFW_MOD_CONTROL);
    else control_press(in->control, CONTROL_ORBIT, x, y);
}

static void on_cursor(GLFWwindow *window, double x, double y)
{
    struct input *in = input_of(window);
    cursor_px(window, &x, &y);
    control_move(in->control, x, y);
}

static void on_scroll(GLFWwindow *window, double dx, double dy)
{
    (void)dx;
    struct input *in = input_of(window);
    double x, y;
    cursor_px(window, &x, &y);
    if (!ui_wants_mouse()) control_wheel(in->control, dy, x, y);
}

// The zoom keys by what is printed on them: + stands elsewhere on every keyboard.
static bool find_control(int key, int scancode, enum control_key *out)
{
    for (int i = 0; i < PLACES; i++) {
        if (places[i].key != key) continue;
        *out = places[i].control;
        return true;
    }
    const char *name = glfwGetKeyName(key, scancode);
    char sign = name && !name[1] ? name[0] : 0;
    *out = sign == '-' ? CONTROL_ZOOM_OUT : CONTROL_ZOOM_IN;
    return sign == '+' || sign == '=' || sign == '-';
}

static void escape(struct input *in)
{
    if (control_is_flying(in->control)) control_set_fly(in->control, false);
    else in->handler(in->user, INPUT_LEAVE);
}

static void run_command(struct input *in, int key, int scancode)
{
    const char *name = glfwGetKeyName(key, scancode);
    char sign = name && !name[1] ? name[0] : 0;
    if (key == GLFW_KEY_F1) in->handler(in->user, INPUT_HELP);
    else if (key == GLFW_KEY_F12) in->handler(in->user, INPUT_SCREENSHOT);
    else if (key == GLFW_KEY_SPACE) in->handler(in->user, INPUT_TOGGLE_TIME);
    else if (key == GLFW_KEY_HOME) control_home(in->control);
    else if (key == GLFW_KEY_ESCAPE) escape(in);
    else if (sign == ',') in->handler(in->user, INPUT_TIME_SLOWER);
    else if (sign == '.') in->handler(in->user, INPUT_TIME_FASTER);
    else if (sign == 'c') in->handler(in->user, INPUT_COPY_CAMERA);
    else if (sign == 'n') control_north_up(in->control);
    else if (sign == 'm') in->handler(in->user, INPUT_NEXT_MODE);
    else if (sign == 'v') in->handler(in->user, INPUT_SPLIT);
    else if (sign == 'x') in->handler(in->user, INPUT_NEXT_DIFFERENCE);
}

static void on_key(GLFWwindow *window, int key, int scancode, int action, int mods)
{
    struct input *in = input_of(window);
    enum control_key control;
    if (action == GLFW_REPEAT) return;
    bool down = action == GLFW_PRESS;
    if (down && ui_wants_keyboard()) return;
    if (find_control(key, scancode, &control)) {
        if (down && key == GLFW_KEY_F && !control_is_flying(in->control))
            control_set_fly(in->control, true);
        else control_key(in->control, control, down);
    } else if (down && !(mods & (GLFW_MOD_CONTROL | GLFW_MOD_ALT | GLFW_MOD_SUPER))) {
        run_command(in, key, scancode);
    }
}

static void on_focus(GLFWwindow *window, int focused)
{
    struct input *in = input_of(window);
    if (!focused) control_stop(in->control);
}

static void on_refresh(GLFWwindow *window)
{
    input_of(window);
}

static void on_size(GLFWwindow *window, int width_px, int height_px)
{
    struct input *in = input_of(window);
    if (width_px > 0 && height_px > 0) control_resize(in->control, width_px, height_px);
}

struct input *input_create(GLFWwindow *window, struct control *control, input_handler handler,
                           void *user)
{
    struct input *in = NEW(struct input);
    in->control = control;
    in->handler = handler;
    in->user = user;
    in->active = true;
    in->pressed_s = -1;
    glfwSetWindowUserPointer(window, in);
    glfwSetMouseButtonCallback(window, on_button);
    glfwSetCursorPosCallback(window, on_cursor);
    glfwSetScrollCallback(window, on_scroll);
    glfwSetKeyCallback(window, on_key);
    glfwSetWindowFocusCallback(window, on_focus);
    glfwSetWindowRefreshCallback(window, on_refresh);
    glfwSetFramebufferSizeCallback(window, on_size);
    return in;
}

void input_destroy(struct input **input)
{
    free(*input);
    *input = NULL;
}

bool input_take_activity(struct input *in)
{
    bool active = in->active;
    in->active = false;
    return active;
}
