/// \file  The queue of branch and bound: blocks of poses that were not expanded yet.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cornerfix {

/// A block of poses, or one: where the centre is, in cells of the padded field, and the heading.
struct Node {
  std::int32_t bound = 0;  ///< No pose in the block scores more.
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::uint8_t rotation = 0;
  bool is_block = false;
};

/// Blocks still to be expanded, those with the highest bound first and the latest of equals first.
/// Bounds are small whole numbers, so one list per bound makes the queue. O(1) per call, amortised.
class Frontier {
 public:
  explicit Frontier(int max_bound) : by_bound_(static_cast<std::size_t>(max_bound) + 1) {}

  void push(const Node& node) {
    by_bound_[static_cast<std::size_t>(node.bound)].push_back(node);
    top_ = std::max(top_, node.bound);
  }
  /// The highest bound of all, or -1.
  [[nodiscard]] int top() {
    while (top_ >= 0 && by_bound_[static_cast<std::size_t>(top_)].empty()) --top_;
    return top_;
  }
  /// Not when it is empty.
  Node pop() {
    std::vector<Node>& nodes = by_bound_[static_cast<std::size_t>(top())];
    const Node node = nodes.back();
    nodes.pop_back();
    return node;
  }

 private:
  std::vector<std::vector<Node>> by_bound_;
  std::int32_t top_ = -1;
};

}  // namespace cornerfix
