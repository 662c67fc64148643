#include "bearing_calibration/common/cancellation.h"

namespace bearing_calibration::core {
namespace {

struct OwnWork {
  const std::atomic<Epoch>* present = nullptr;  ///< null: cannot be cancelled
  Epoch own = 0;
};
thread_local OwnWork own_work;

}  // namespace

WorkOfEpoch::WorkOfEpoch(const std::atomic<Epoch>& present, Epoch own) {
  own_work = {&present, own};
}

WorkOfEpoch::~WorkOfEpoch() { own_work = {}; }

void endIfCancelled() {
  if (own_work.present != nullptr && *own_work.present != own_work.own) throw Cancelled();
}

}  // namespace bearing_calibration::core
