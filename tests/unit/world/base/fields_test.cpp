// A list of fields has one entry for each member of its struct, in their order.

#include "world/base/fields.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "world/api/commands/command_fields.hpp"
#include "world/api/description/description_fields.hpp"
#include "world/api/ports/history_fields.hpp"
#include "world/api/snapshot/snapshot_fields.hpp"

namespace aprsim::fields {
namespace {

struct Sample {
  int first = 0;
  std::optional<double> second;
  std::array<double, 2> third{};
};

template <typename... Members>
consteval bool is_list_of_sample(Members... members) {
  return is_complete<Sample>(std::make_tuple(field(members, Omitted())...));
}

TEST(Fields, AListNeedsAnEntryForEachMemberInOrder) {
  EXPECT_TRUE(is_list_of_sample(&Sample::first, &Sample::second, &Sample::third));
  EXPECT_FALSE(is_list_of_sample(&Sample::first, &Sample::second));
  EXPECT_FALSE(is_list_of_sample(&Sample::first, &Sample::third));
  EXPECT_FALSE(is_list_of_sample(&Sample::second, &Sample::third));
  EXPECT_FALSE(is_list_of_sample(&Sample::second, &Sample::first, &Sample::third));
  EXPECT_FALSE(is_list_of_sample());
}

struct Archived {
  int kept = 1, omitted = 2, left_out = 3;
};
APRSIM_FIELDS(Archived, FIELD(kept), BY_HAND(omitted), NOWHERE(left_out))

TEST(Fields, ArchivesHaveAllButThoseThatAreNowhere) {
  std::vector<int> all;
  const Archived value;
  for_each_archived(value, [&all](int member) { all.push_back(member); });
  EXPECT_EQ(all, (std::vector<int>{1, 2}));
}

/// Checks the lists of T and of all that its members hold.
template <typename T>
struct Check {
  static void lists() {
    if constexpr (Listed<T>) {
      const T value{};
      const auto* last = reinterpret_cast<const std::byte*>(&value) - 1;
      for_each<T>([&]<typename Field>(const Field& each) {
        const auto& member = value.*each.member;
        const auto* place = reinterpret_cast<const std::byte*>(&member);
        EXPECT_GT(place, last) << __PRETTY_FUNCTION__;
        last = place;
        Check<std::remove_cvref_t<decltype(member)>>::lists();
      });
    }
  }
};
template <typename T>
struct Check<const T> : Check<T> {};
template <typename T>
struct Check<std::vector<T>> : Check<T> {};
template <typename T>
struct Check<std::optional<T>> : Check<T> {};
template <typename T>
struct Check<std::shared_ptr<T>> : Check<T> {};
template <typename T, std::size_t n>
struct Check<std::array<T, n>> : Check<T> {};
template <typename... T>
struct Check<std::variant<T...>> {
  static void lists() { (Check<T>::lists(), ...); }
};

/// An entry that stands twice takes the place of another, of the same type.
TEST(Fields, NoListHasAMemberTwice) {
  Check<api::Command>::lists();
  Check<api::Snapshot>::lists();
  Check<api::CellDescription>::lists();
  Check<api::CellEvent>::lists();
  Check<api::HistorySpan>::lists();
  Check<api::Bookmark>::lists();
  Check<faults::KindInfo>::lists();
  Check<faults::QuantityInfo>::lists();
}

}  // namespace
}  // namespace aprsim::fields
