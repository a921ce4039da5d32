// What --help prints. Works without a GPU and without any file.
#ifndef PERIGEE_APP_HELP_H
#define PERIGEE_APP_HELP_H

#include <stdio.h>

#include "app/options.h"

void help_program(FILE *f);
void help_command(FILE *f, enum command command);

#endif
