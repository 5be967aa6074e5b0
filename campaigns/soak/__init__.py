"""The whole graph over DDS for as long as one likes: what its processes take, lose and need in time."""
