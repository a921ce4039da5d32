// The subcommands. Each has logged one line when it returns another status than OK. Main only.
#ifndef PERIGEE_APP_COMMAND_H
#define PERIGEE_APP_COMMAND_H

#include "app/options.h"

status command_view(const struct options *o);
status command_render(const struct options *o);
status command_fly(const struct options *o);
status command_import(const struct options *o);
status command_info(const struct options *o);
status command_compare(const struct options *o);
status command_export(const struct options *o);

// The whole program: its exit status. 0, 1 after one line on standard error, 130 after Ctrl-C.
int command_main(int argc, char **argv);

#endif
