#include "bearing_calibration/planning/region.h"

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/linestring.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>
#include <boost/geometry/geometries/segment.hpp>

#include "bearing_calibration/common/plausible.h"
#include "bearing_calibration/common/requirement.h"

namespace bearing_calibration::core {
namespace {

namespace geometry = boost::geometry;
using Point = geometry::model::d2::point_xy<double>;
using Polygon = geometry::model::polygon<Point>;
using Line = geometry::model::linestring<Point>;

Point pointFrom(const Eigen::Vector2d& vector) { return {vector.x(), vector.y()}; }

Polygon polygonFrom(const std::vector<Eigen::Vector2d>& corners) {
  Polygon polygon;
  for (const Eigen::Vector2d& corner : corners) geometry::append(polygon, pointFrom(corner));
  geometry::correct(polygon);  // closed, and in the order that the library wants
  return polygon;
}

}  // namespace

std::vector<std::string> Region::validate() const {
  constexpr std::size_t kLeastCorners = 3;
  Requirements require;
  const double least_m = polygon_m.empty() ? plausible::kShortest_m : 0.0;
  require.between("region/radius", radius_m, least_m, plausible::kFarthest_m);
  if (polygon_m.empty()) return require.errors();
  require.that(
      polygon_m.size() >= kLeastCorners,
      "region/polygon must have at least 3 corners, but has " + std::to_string(polygon_m.size()));
  for (const Eigen::Vector2d& corner : polygon_m) {
    require.that(corner.cwiseAbs().maxCoeff() <= plausible::kFarthest_m,
                 "region/polygon must lie within 1000 m of the start");
  }
  if (!require.errors().empty()) return require.errors();
  require.that(geometry::is_valid(polygonFrom(polygon_m)), "region/polygon must not cross itself");
  require.that(clearance(Eigen::Vector2d::Zero()) > 0.0,
               "region/polygon must contain the start, (0, 0)");
  return require.errors();
}

double Region::clearance(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  if (polygon_m.empty()) return radius_m - std::max(from.norm(), to.norm());
  const Polygon polygon = polygonFrom(polygon_m);
  const geometry::model::segment<Point> way(pointFrom(from), pointFrom(to));
  const Line border(polygon.outer().begin(), polygon.outer().end());
  const auto to_border = [&border](const auto& what) { return geometry::distance(what, border); };
  if (!geometry::within(pointFrom(from), polygon)) return -to_border(pointFrom(from));
  if (!geometry::within(pointFrom(to), polygon)) return -to_border(pointFrom(to));
  return to_border(way);  // zero where it crosses the border
}

}  // namespace bearing_calibration::core
