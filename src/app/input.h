// Mouse and keyboard of a GLFW window, translated for the camera controller and into commands. Main
// only.
#ifndef PERIGEE_APP_INPUT_H
#define PERIGEE_APP_INPUT_H

#include <stdbool.h>

struct GLFWwindow;
struct control;
struct input;

enum input_command {
    INPUT_HELP,
    INPUT_SCREENSHOT,
    INPUT_COPY_CAMERA,
    INPUT_TOGGLE_TIME,
    INPUT_TIME_SLOWER,
    INPUT_TIME_FASTER,
    INPUT_NEXT_MODE,
    INPUT_SPLIT,
    INPUT_NEXT_DIFFERENCE,
    INPUT_LEAVE, // Esc outside of fly mode
};

typedef void (*input_handler)(void *user, enum input_command command);

// Installs its callbacks and takes the window's user pointer. The controller outlives the input.
struct input *input_create(struct GLFWwindow *window, struct control *control,
                           input_handler handler, void *user);
void input_destroy(struct input **input);

// true when anything has come in since the last call.
bool input_take_activity(struct input *input);

#endif
