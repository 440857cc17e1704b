#pragma once
// One picture a technique, all of one scene: how it looks, and one place of it larger, above what the truth has there.

#include <map>
#include <string>

#include "bin/options.h"
#include "techniques/technique.h"

namespace gnomon {

class TechniquePictures {
public:
    // The default scene at four times the size at which it is shown, so that techniques meet the pixels of a usual
    // screen; colours are even, without falloff or highlights, so that shadows are what one sees.
    TechniquePictures();

    // Display-referred sRGB of 600 x 225 pixels. Throws UsageError where the technique does not support the scene's
    // light, a rectangle.
    Image<vec3> draw(const Entry& entry);

private:
    const Image<vec3>& shaded(const std::string& specification);

    Stage stage_;
    Frame frame_;
    std::map<std::string, Image<vec3>> shaded_; // the references, once they are made
};

} // namespace gnomon
