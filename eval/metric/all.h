#pragma once
// The rows of the table in eval/metrics.cpp, one function a file.

#include "eval/metrics.h"

namespace gnomon {

Metric mae_metric();
Metric mse_metric();
Metric rmse_metric();
Metric psnr_metric();
Metric max_metric();
Metric ssim_metric();
Metric leak_metric();
Metric false_shadow_metric();
Metric over_metric();
Metric under_metric();

double mean_square_error(const ImagePair& pair); // what RMSE and PSNR are made of

} // namespace gnomon
