# What kerf_volumes.so links: ITK, which reads label volumes.
set(ITKVtkGlue_LOADED TRUE)  # ITK 5.4 loads all its modules, whatever the components: this one would look for VTK, Qt and MPI
find_package(ITK REQUIRED COMPONENTS ITKCommon ITKIOImageBase ITKIOBMP ITKIOGDCM ITKIOMeta ITKIONIFTI ITKIONRRD ITKIOPNG ITKIOTIFF)
find_path(KERF_GDCM_INCLUDE_DIR gdcmTrace.h PATH_SUFFIXES gdcm-3.0 REQUIRED)  # ITK reads DICOM with it; to silence it and to ask what it states
find_library(KERF_GDCM_COMMON gdcmCommon REQUIRED)
find_library(KERF_GDCM_DSED gdcmDSED REQUIRED)
