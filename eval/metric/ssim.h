#pragma once
// The two means that SSIM and MS-SSIM are made of, over one scale of a pair of images.

#include "eval/metrics.h"

namespace gnomon {

inline constexpr int ssim_window = 11;

struct SimilarityMeans {
    double ssim, contrast_structure; // of the windows; NaN without any
};

// Over the windows that lie inside the images and are centred on a pixel that takes part; pixels that do not take part
// have no weight in any window.
SimilarityMeans similarity_means(const ImagePair& pair);

// Five scales of similarity_means [Wang, Simoncelli, Bovik 2003], the first of which is given. NaN where the images
// are too small for five.
double multi_scale_similarity(const ImagePair& pair, const SimilarityMeans& finest);

} // namespace gnomon
