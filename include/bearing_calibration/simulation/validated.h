#pragma once

#include "bearing_calibration/common/validated.h"
