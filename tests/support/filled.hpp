#pragma once

#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <Eigen/Geometry>

#include "world/base/fields.hpp"

/// Values of which nothing has its default: to see whether all of it arrives.
namespace aprsim::test {

/// Fills a value by its list of fields. Numbers differ; integers are 1, a valid index as every list
/// has two elements; an enumeration has its second value. A
/// struct without a list stays as it is.
class Filler {
 public:
  template <typename T>
  void operator()(T& value) {
    if constexpr (std::is_enum_v<T>) {
      value = static_cast<T>(1);
    } else if constexpr (std::is_integral_v<T>) {
      value = 1;
    } else if constexpr (std::is_floating_point_v<T>) {
      value = next();
    } else if constexpr (requires(Filler filler) { filler.fill(value); }) {
      fill(value);
    }
  }

 private:
  double next() { return ++count_ + 0.25; }

  void fill(std::string& value) { value = "text " + std::to_string(++count_); }
  void fill(std::chrono::nanoseconds& value) {
    value = std::chrono::milliseconds(1500) + std::chrono::seconds(++count_);
  }
  void fill(Eigen::Vector2d& value) { value = {next(), next()}; }
  void fill(Eigen::Vector3d& value) { value = {next(), next(), next()}; }
  void fill(Eigen::Quaterniond& value) { value = {next(), next(), next(), next()}; }
  template <typename T>
  void fill(std::optional<T>& value) {
    (*this)(value.emplace());
  }
  template <typename T>
  void fill(std::vector<T>& value) {
    value.resize(2);
    for (T& each : value) (*this)(each);
  }
  template <typename T, std::size_t n>
  void fill(std::array<T, n>& value) {
    for (T& each : value) (*this)(each);
  }
  template <typename T>
  void fill(std::map<std::string, T>& value) {
    (*this)(value["key"]);
  }
  template <typename... T>
  void fill(std::variant<T...>& value) {
    using First = std::variant_alternative_t<0, std::variant<T...>>;
    constexpr std::size_t kIndex = std::is_same_v<First, std::monostate> ? 1 : 0;
    (*this)(value.template emplace<kIndex>());
  }
  template <typename T>
  void fill(std::shared_ptr<const T>& value) {
    if constexpr (requires(Filler filler, T & of) { filler.fill(of); }) {
      auto filled = std::make_shared<T>();
      fill(*filled);
      value = filled;
    }
  }
  template <fields::Listed T>
  void fill(T& value) {
    fields::for_each<T>([&](const auto& each) { (*this)(value.*each.member); });
  }

  int count_ = 0;
};

template <typename T>
[[nodiscard]] T filled() {
  T value;
  Filler{}(value);
  return value;
}

}  // namespace aprsim::test
