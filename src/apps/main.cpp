#include "src/apps/command_line.hpp"

int main(int argc, char** argv) { return static_cast<int>(pled::apps::run(argc, argv)); }
