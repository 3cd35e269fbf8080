// The command line: words to a command, a command to an exit code.
#pragma once

namespace pliant {

/// Parses the words, runs the command, prints what went wrong to standard error, each line of it Pliant's
/// own. Returns the exit code of the program (see ExitCode); throws nothing.
int run_program(int argc, char** argv);

} // namespace pliant
