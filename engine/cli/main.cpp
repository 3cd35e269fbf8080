// The program: everything is in commands.
#include "engine/cli/program.h"

int main(int argc, char** argv) {
  return pliant::run_program(argc, argv);
}
