#pragma once
// The two Embree generations differ in where a query's flags and filter go; what includes this knows neither.

#if __has_include(<embree3/rtcore.h>)
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

namespace gnomon {

#if RTC_VERSION_MAJOR >= 4

using QueryContext = RTCRayQueryContext;
inline constexpr RTCSceneFlags filter_in_query = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;
inline constexpr auto query_flags =
    static_cast<RTCRayQueryFlags>(RTC_RAY_QUERY_FLAG_INCOHERENT | RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER);

inline void start_query(QueryContext& context) { rtcInitRayQueryContext(&context); }

inline void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCFilterFunctionN filter,
                     RTCRay16& rays) {
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    arguments.filter = filter;
    arguments.flags = query_flags;
    rtcOccluded16(valid, scene, &rays, &arguments);
}

inline void intersect(RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRayHit& ray) {
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    arguments.filter = filter;
    arguments.flags = query_flags;
    rtcIntersect1(scene, &ray, &arguments);
}

#else

using QueryContext = RTCIntersectContext;
inline constexpr RTCSceneFlags filter_in_query = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

inline void start_query(QueryContext& context) { rtcInitIntersectContext(&context); }

inline void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCFilterFunctionN filter,
                     RTCRay16& rays) {
    context.filter = filter;
    rtcOccluded16(valid, scene, &context, &rays);
}

inline void intersect(RTCScene scene, QueryContext& context, RTCFilterFunctionN filter, RTCRayHit& ray) {
    context.filter = filter;
    rtcIntersect1(scene, &context, &ray);
}

#endif

} // namespace gnomon
