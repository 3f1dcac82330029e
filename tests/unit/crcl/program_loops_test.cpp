#include "crcl/program_loops.hpp"

#include <gtest/gtest.h>

namespace aprsim::crcl {
namespace {

Program loops(std::vector<CommandBody> bodies) {
  Program out;
  for (auto& body : bodies) {
    Command command;
    command.body = std::move(body);
    out.commands.push_back(std::move(command));
  }
  return out;
}

TEST(ProgramLoops, LoopsNestAndMayBeEmptyOrSkipped) {
  const auto nested =
      expand_loops(loops({InitCanon{}, LoopBlockStart{"a"}, Dwell{1}, LoopBlockStart{"b"}, Dwell{2},
                          LoopBlockEnd{"b", 2}, LoopBlockEnd{"a", 3}, LoopBlockStart{"c"}, Dwell{9},
                          LoopBlockEnd{"c", 0}}));
  ASSERT_TRUE(nested.has_value());
  EXPECT_EQ(nested->size(), 1U + 3U * 3U);
}

TEST(ProgramLoops, BrokenOrBoundlessLoopsAreRefused) {
  EXPECT_FALSE(expand_loops(loops({LoopBlockStart{"a"}})).has_value());
  EXPECT_FALSE(expand_loops(loops({LoopBlockEnd{"a", 1}})).has_value());
  EXPECT_FALSE(expand_loops(loops({LoopBlockStart{"a"}, LoopBlockEnd{"b", 1}})).has_value());
  EXPECT_FALSE(expand_loops(loops({LoopBlockStart{"a"}, LoopBlockStart{"b"}, Dwell{1},
                                   LoopBlockEnd{"b", 100'000}, LoopBlockEnd{"a", 100'000}}))
                   .has_value());
}

TEST(ProgramLoops, GiveThePlacesOfTheCommands) {
  const auto order = expand_loops(loops(
      {InitCanon{}, LoopBlockStart{"a"}, Dwell{1}, Dwell{2}, LoopBlockEnd{"a", 2}, EndCanon{}}));
  EXPECT_EQ(order.value(), (std::vector<std::size_t>{0, 2, 3, 2, 3, 5}));
}

TEST(ProgramLoops, MayNestAsDeepAsADocumentIsLong) {
  std::vector<CommandBody> bodies(200'000, LoopBlockStart{"a"});
  bodies.insert(bodies.end(), 200'000, LoopBlockEnd{"a", 1});
  EXPECT_TRUE(expand_loops(loops(std::move(bodies))).has_value());
}

}  // namespace
}  // namespace aprsim::crcl
