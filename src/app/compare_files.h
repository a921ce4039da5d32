// What files as sides of a comparison bring with them: their camera and their size. Main only.
#ifndef PERIGEE_APP_COMPARE_FILES_H
#define PERIGEE_APP_COMPARE_FILES_H

#include "app/compare_side.h"

bool compare_side_is_file(const struct compare_side *side);

// Opens the sides of these names and sets the stage's size and samples by the options and by files,
// whose camera goes to *camera when there is one (*files). Sides are to be closed whatever the
// status. ERR_ARGUMENT, logged: files of two cameras, options that a file contradicts.
status compare_files_open(const char *const *names, int count, struct compare_side *sides,
                          struct compare_stage *stage, bool *files, perigee_camera *camera);

// Pictures of another planet are worth a warning only: names can be changed.
void compare_files_check_planet(const struct compare_side *sides, int count, const char *planet);

#endif
