"""Pictures in three dimensions: meshes of a scene, cameras, rasters, films."""
