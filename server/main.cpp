#include "server/run.hpp"

int main(int argc, char** argv) { return aprsim::server::run(argc, argv); }
