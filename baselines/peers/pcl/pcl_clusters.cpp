// PCL's two Euclidean clusterings behind two C functions: n points of x, y, z, intensity in, a label for each out, -1 for none.

#include <pcl/pcl_config.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/conditional_euclidean_clustering.h>
#include <pcl/segmentation/extract_clusters.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace {

using Point = pcl::PointXYZI;
using PointCloud = pcl::PointCloud<Point>;

PointCloud::Ptr cloud_of(const float* points, std::int64_t n_points) {
    PointCloud::Ptr cloud(new PointCloud);
    cloud->resize(static_cast<std::size_t>(n_points));
    for (std::int64_t i = 0; i < n_points; ++i) {
        Point& point = (*cloud)[static_cast<std::size_t>(i)];
        const float* row = points + 4 * i;
        point.x = row[0];
        point.y = row[1];
        point.z = row[2];
        point.intensity = row[3];
    }
    return cloud;
}

void label(const std::vector<pcl::PointIndices>& clusters, std::int64_t n_points, std::int32_t* labels) {
    std::fill(labels, labels + n_points, -1);
    std::int32_t cluster_idx = 0;
    for (const auto& cluster : clusters) {
        for (const auto point_idx : cluster.indices) labels[point_idx] = cluster_idx;
        ++cluster_idx;
    }
}

float range_m(const Point& point) { return std::hypot(point.x, point.y); }

}  // namespace

extern "C" {

const char* pcl_version() { return PCL_VERSION_PRETTY; }

void euclidean(const float* points, std::int64_t n_points, double tolerance_m, std::int32_t min_points,
               std::int32_t max_points, std::int32_t* labels) {
    const auto cloud = cloud_of(points, n_points);
    pcl::search::KdTree<Point>::Ptr tree(new pcl::search::KdTree<Point>);
    tree->setInputCloud(cloud);
    pcl::EuclideanClusterExtraction<Point> extraction;
    extraction.setClusterTolerance(tolerance_m);
    extraction.setMinClusterSize(min_points);
    extraction.setMaxClusterSize(max_points);
    extraction.setSearchMethod(tree);
    extraction.setInputCloud(cloud);
    std::vector<pcl::PointIndices> clusters;
    extraction.extract(clusters);
    label(clusters, n_points, labels);
}

// Two points belong together if they are nearer than tolerance_m + tolerance_per_m × the range of the nearer one, and their
// intensities differ by less than max_intensity_difference.
void conditional_euclidean(const float* points, std::int64_t n_points, double tolerance_m, double tolerance_per_m,
                           double max_tolerance_m, double max_intensity_difference, std::int32_t min_points,
                           std::int32_t max_points, std::int32_t* labels) {
    pcl::ConditionalEuclideanClustering<Point> clustering;
    clustering.setInputCloud(cloud_of(points, n_points));
    clustering.setClusterTolerance(static_cast<float>(max_tolerance_m));
    clustering.setMinClusterSize(min_points);
    clustering.setMaxClusterSize(max_points);
    clustering.setConditionFunction([=](const Point& a, const Point& b, float squared_distance) {
        const double allowed_m =
            std::min(max_tolerance_m, tolerance_m + tolerance_per_m * std::min(range_m(a), range_m(b)));
        return squared_distance <= allowed_m * allowed_m &&
               std::abs(a.intensity - b.intensity) < max_intensity_difference;
    });
    std::vector<pcl::PointIndices> clusters;
    clustering.segment(clusters);
    label(clusters, n_points, labels);
}

}  // extern "C"
