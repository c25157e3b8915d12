// SPDX-License-Identifier: Apache-2.0
// Discrete GPUs lower their clocks within moments of idling and take long to raise them: what is timed right after a
// pause runs at a fraction of its speed. This keeps such a device busy until its clocks stand, and shortly before every
// timed run. On devices that are the CPU it does nothing.
// Borrows the device. Threads: as the device.
#pragma once

#include <memory>

#include "runtime/device/compute_kernel.h"

namespace zc::bench {

class ClockWarmer {
 public:
  static Result<ClockWarmer> create(Device& device);
  // A tenth of a second of work; the first time until it has not become faster for two seconds, six at most.
  Status warm();

 private:
  Result<double> spin();

  std::unique_ptr<ComputeKernel> kernel_;  // none: nothing to warm
  Buffer sums_;
  bool warm_ = false;
};

}  // namespace zc::bench
