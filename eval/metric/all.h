#pragma once
// The measures of the table in eval/metrics.cpp, one function a file.

#include "eval/metrics.h"

namespace gnomon {

Measure mae_measure();
Measure mse_measure();
Measure rmse_measure();
Measure psnr_measure();
Measure max_measure();
Measure relmse_measure();
Measure ssim_measure(); // SSIM and MS-SSIM
Measure flip_measure();
Measure flip_hdr_measure();
Measure classes_measure(); // the share of wrong classes, and the overlap of right ones
Measure leak_measure();
Measure false_shadow_measure();
Measure over_measure();
Measure under_measure();
Measure edges_measure(); // silhouette distances, penumbra width, jaggedness
Measure banding_measure();
Measure temporal_measure();

double mean_square_error(const ImagePair& pair); // what RMSE and PSNR are made of

} // namespace gnomon
