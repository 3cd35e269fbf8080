// The program: everything is in commands.
#include <cstdio>
int main(int, char**) { return 0; }
