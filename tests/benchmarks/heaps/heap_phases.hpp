#pragma once

#include <string>

namespace aprsim::bench {

/// The experiment of heaps of every kind of parts and several sizes, on a table or between `walls`:
/// cost and exactness of a step while parts strike each other, and once they settle. `place` ends
/// the sentence "Parts at random attitudes fall in layers ...".
int run_heap_phases(const std::string& name, bool walls, const std::string& place, int argc,
                    char** argv);

}  // namespace aprsim::bench
