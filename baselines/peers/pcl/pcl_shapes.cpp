// PCL's two global descriptors of a cloud behind two C functions: n points of x, y, z in, a histogram out.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <ctime>

#include <pcl/features/normal_3d.h>
#include <pcl/features/vfh.h>
#include <pcl/pcl_config.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>

// ESF draws its triples of points from a generator that it seeds with the clock. It is compiled here with a clock that stands, so that a
// cloud gives the same histogram whenever it is asked for.
#define time(ignored) 1
#include <pcl/features/esf.h>
#include <pcl/features/impl/esf.hpp>
#undef time

namespace {

using Point = pcl::PointXYZ;
using PointCloud = pcl::PointCloud<Point>;

PointCloud::Ptr cloud_of(const float* points, std::int64_t n_points) {
    PointCloud::Ptr cloud(new PointCloud);
    cloud->resize(static_cast<std::size_t>(n_points));
    for (std::int64_t i = 0; i < n_points; ++i) {
        (*cloud)[static_cast<std::size_t>(i)] = Point(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    }
    return cloud;
}

}  // namespace

extern "C" {

const char* pcl_version() { return PCL_VERSION_PRETTY; }

// Ensemble of Shape Functions (Wohlkinger and Vincze 2011), 640 values.
void esf(const float* points, std::int64_t n_points, float* histogram) {
    pcl::ESFEstimation<Point, pcl::ESFSignature640> estimation;
    estimation.setInputCloud(cloud_of(points, n_points));
    pcl::PointCloud<pcl::ESFSignature640> found;
    estimation.compute(found);
    std::copy(std::begin(found[0].histogram), std::end(found[0].histogram), histogram);
}

// Viewpoint Feature Histogram (Rusu et al. 2010), 308 values, seen from the origin.
void vfh(const float* points, std::int64_t n_points, std::int32_t n_neighbors, float* histogram) {
    const auto cloud = cloud_of(points, n_points);
    pcl::search::KdTree<Point>::Ptr tree(new pcl::search::KdTree<Point>);
    pcl::PointCloud<pcl::Normal>::Ptr normals(new pcl::PointCloud<pcl::Normal>);
    pcl::NormalEstimation<Point, pcl::Normal> normal_estimation;
    normal_estimation.setInputCloud(cloud);
    normal_estimation.setSearchMethod(tree);
    normal_estimation.setKSearch(n_neighbors);
    normal_estimation.compute(*normals);
    pcl::VFHEstimation<Point, pcl::Normal, pcl::VFHSignature308> estimation;
    estimation.setInputCloud(cloud);
    estimation.setInputNormals(normals);
    estimation.setSearchMethod(tree);
    pcl::PointCloud<pcl::VFHSignature308> found;
    estimation.compute(found);
    std::copy(std::begin(found[0].histogram), std::end(found[0].histogram), histogram);
}

}  // extern "C"
