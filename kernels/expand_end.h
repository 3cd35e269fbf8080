// Ends one reading of a declaration.
#undef KERNEL_BEGIN
#undef KERNEL_OPTION
#undef KERNEL_PARAM
#undef KERNEL_TABLE
#undef KERNEL_IN
#undef KERNEL_OUT
#undef KERNEL_INOUT
#undef KERNEL_END
