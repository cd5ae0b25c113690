/* unit fp_end: the user's options again. clang and MSVC keep contraction off to the end of the file. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif
