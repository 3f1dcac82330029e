#include "world/physics/constraint/block_lu.hpp"

#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

namespace aprsim::physics {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// Fills a system of random blocks and the same as one dense matrix. `shifted`: the greatest number
/// of a column stands so many rows below the diagonal.
Eigen::MatrixXd fill(BlockLu& lu, int count, const Pairs& pairs, int shifted,
                     std::mt19937& engine) {
  std::uniform_real_distribution<double> value(-1, 1);
  const auto random = [&] {
    return BlockLu::Block(BlockLu::Block::NullaryExpr([&] { return value(engine); }));
  };
  const auto size = Eigen::Index{6} * count;
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  const auto add = [&](BlockLu::Block& block, Eigen::Index row, Eigen::Index column,
                       const BlockLu::Block& part) {
    block += part;
    dense.block<6, 6>(6 * row, 6 * column) += part;
  };
  lu.analyse(count, pairs);
  lu.set_zero();
  for (int i = 0; i < count; ++i) {
    BlockLu::Block great = BlockLu::Block::Zero();
    for (int k = 0; k < 6; ++k) great((k + shifted) % 6, k) = 20;
    add(lu.diagonal(i), i, i, random() + great);
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto place = lu.pair_blocks(k);
    add(lu.forward(place), pairs[k].first, pairs[k].second, random());
    add(lu.backward(place), pairs[k].second, pairs[k].first, random());
  }
  return dense;
}

TEST(BlockLu, SolvesAsTheDenseMatrixDoes) {
  std::mt19937 engine(3);
  BlockLu lu;  // the same one, larger and smaller
  for (int round = 0; round < 200; ++round) {
    const int count = std::uniform_int_distribution<int>(1, 25)(engine);
    std::uniform_int_distribution<int> body(0, count - 1);
    Pairs pairs;
    for (int k = std::uniform_int_distribution<int>(0, 3 * count)(engine); k > 0; --k) {
      const int a = body(engine), b = body(engine);
      if (a != b) pairs.emplace_back(a, b);  // also the same pair more than once
    }
    const Eigen::MatrixXd dense = fill(lu, count, pairs, round % 6, engine);
    ASSERT_TRUE(lu.factorise());
    std::vector<BlockLu::BlockVector> x(static_cast<std::size_t>(count));
    Eigen::VectorXd right = Eigen::VectorXd::Random(dense.rows());
    for (int i = 0; i < count; ++i) {
      x[static_cast<std::size_t>(i)] = right.segment<6>(Eigen::Index{6} * i);
    }
    ASSERT_TRUE(lu.solve(x));
    const Eigen::VectorXd expected = dense.partialPivLu().solve(right);
    for (int i = 0; i < count; ++i) {
      const BlockLu::BlockVector off =
          x[static_cast<std::size_t>(i)] - expected.segment<6>(Eigen::Index{6} * i);
      ASSERT_LT(off.norm(), 1e-11) << "round " << round << ", body " << i;
    }
  }
}

TEST(BlockLu, SaysThatAPivotIsSingular) {
  BlockLu lu;
  lu.analyse(2, Pairs{});
  lu.set_zero();
  lu.diagonal(0).setIdentity();
  std::vector<BlockLu::BlockVector> x(2, BlockLu::BlockVector::Ones());
  EXPECT_TRUE(lu.factorise());
  EXPECT_FALSE(lu.solve(x));
  // One that another body hangs on.
  lu.analyse(2, Pairs{{0, 1}});
  lu.set_zero();
  lu.diagonal(1).setIdentity();
  EXPECT_FALSE(lu.factorise());
}

}  // namespace
}  // namespace aprsim::physics
