#ifdef __cplusplus
}
#endif

#endif /* LIGHTSAMPLING_H */
