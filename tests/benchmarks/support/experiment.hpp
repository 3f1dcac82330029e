#pragma once

#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/benchmarks/support/plot.hpp"
#include "tests/benchmarks/support/table.hpp"

namespace aprsim::bench {

/// One measured number. `against` names what it is compared with ("" = nothing), `ratio` is this
/// value over that one's.
struct Result {
  std::string name;
  double value = 0;
  std::string unit;
  std::string against;
  double ratio = std::numeric_limits<double>::quiet_NaN();
};

/// Everything one experiment program leaves behind, in OUT/NAME: results.json, one CSV a table, one
/// SVG a plot. tests/benchmarks/summary.py makes RESULTS.md of it.
class Experiment {
 public:
  /// Takes `--quick` (a reduced grid, to see that it runs) and `--out DIR` (default: the working
  /// directory) from the command line; exits with a message for anything else.
  Experiment(std::string name, int argc, char** argv);

  [[nodiscard]] bool quick() const { return quick_; }

  /// Prints it too. Throws std::invalid_argument for a value that is not finite or a name that was
  /// recorded before.
  void record(Result result);
  void record(std::string name, double value, std::string unit) {
    record(Result{std::move(name), value, std::move(unit)});
  }
  /// A sentence for RESULTS.md.
  void note(std::string text);
  /// A version that only this program knows.
  void version(std::string library, std::string version);
  /// Writes FILE.csv; RESULTS.md shows the table under `title` unless that is empty.
  void table(const std::string& file, const std::string& title, const Table& table);
  /// Writes FILE.svg.
  void plot(const std::string& file, const Plot& plot);

  /// Writes results.json; the program's exit code.
  int finish();

 private:
  void write(const std::string& file, const std::string& text) const;

  std::string name_;
  bool quick_ = false;
  std::filesystem::path folder_ = ".";
  double started_s_ = 0;
  std::vector<Result> results_;
  std::vector<std::string> notes_, plots_;
  std::vector<std::pair<std::string, std::string>> versions_;
  struct Shown {
    std::string file, title;
    Table table;
  };
  std::vector<Shown> tables_;
};

}  // namespace aprsim::bench
